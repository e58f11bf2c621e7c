#!/usr/bin/env bash
# Races pktrt in WebAssembly with three-mesh-bvh; see the head of bench/three.mjs. usage: three.sh PROVENANCE RESULTS, and in the
# environment SCENE=conference, ROUNDS=9. npm brings the newest three-mesh-bvh to build/three, once: removing that folder
# brings it anew. Without npm or its registry there is nothing to compare with, which is no failure.
set -u
cd "$(dirname "$0")/.." || exit 1
work=build/three provenance=$1 results=$2
for program in emcc node npm; do
  command -v $program >/dev/null ||
    { echo "bench-three: $program is not installed (make deps-extra, deps-web), nothing to compare with"; exit 0; }
done
mkdir -p $work
[ -d $work/node_modules/three-mesh-bvh ] ||
  npm install --prefix $work --ignore-scripts --no-audit --no-fund --fetch-retries 1 three three-mesh-bvh >$work/npm.txt 2>&1 ||
  { echo "bench-three: npm cannot install three-mesh-bvh ($work/npm.txt says why), nothing to compare with"; exit 0; }
export NODE_PATH=/usr/share/nodejs${NODE_PATH:+:$NODE_PATH} # emcc wants Debian's acorn
emcc -O2 -msimd128 -std=gnu99 -ffp-contract=off -idirafter /usr/include -s ALLOW_MEMORY_GROWTH=1 \
  -s SINGLE_FILE=1 -s MODULARIZE=1 -s ENVIRONMENT=node -s EXPORTED_RUNTIME_METHODS=ccall --no-entry bench/three.c -o $work/pktrt.js ||
  exit 1
cp bench/three.mjs $work/ # beside what it imports
node $work/three.mjs "${SCENE:-poolhall}" "${ROUNDS:-5}" $work/figures || exit 1
{
  "$provenance" make bench-three ${SCENE:+SCENE=$SCENE} ${ROUNDS:+ROUNDS=$ROUNDS}
  cat $work/figures.csv
} >"$results/three.csv"
cp $work/figures.md "$results/three.md"
