#!/usr/bin/env bash
# Compiles bench/wasm.c for WebAssembly with its vectors and without, lets node run both in turns, and prints how many times as fast
# vectors are: the median of three rounds, by kind of rays, geometric mean of the scenes.
set -uo pipefail
cd "$(dirname "$0")/.." || exit 1
work=build/wasm
for program in emcc node; do
  command -v $program >/dev/null || { echo "bench-wasm: $program is not installed (make deps-extra)"; exit 1; }
done
mkdir -p $work/include
ln -sfn /usr/include/stb $work/include/stb # alone: the other headers there are not emcc's
export NODE_PATH=/usr/share/nodejs${NODE_PATH:+:$NODE_PATH} # emcc wants Debian's acorn
compile() { # program, flags...
  emcc -O2 -std=gnu99 -ffp-contract=off "${@:2}" -I$work/include -s ALLOW_MEMORY_GROWTH=1 -s SINGLE_FILE=1 bench/wasm.c -o "$work/$1.js"
}
compile vectors -msimd128 && compile scalar || exit 1
for round in 1 2 3; do
  for program in vectors scalar; do node $work/$program.js >$work/$program.$round || exit 1; done
  paste -d' ' $work/vectors.$round $work/scalar.$round
done | awk '
  function median(a, b, c) { return a > b ? (b > c ? b : a > c ? c : a) : (a > c ? a : b > c ? c : b) }
  NF != 8 || $1 != $5 || $2 != $6 || !($3 > 0 && $4 > 0) { print "bench-wasm: a round went wrong: " $0; bad = 1; exit 1 }
  { key = $1 " " $2; n = ++rounds[key]; many[key, n] = $7 / $3; single[key, n] = $8 / $4; kind[key] = $2 }
  END {
    for (key in kind) bad = bad || rounds[key] != 3
    if (bad || !NR) { print "bench-wasm: nothing to tell, or not three rounds of it"; exit 1 }
    printf "| rays | many | single |\n|---|--:|--:|\n"
    for (key in kind) {
      k = kind[key]; m = log(median(many[key, 1], many[key, 2], many[key, 3]))
      s = log(median(single[key, 1], single[key, 2], single[key, 3]))
      of[k]++; sum[k] += m; one[k] += s; all++; total += m; alone += s
    }
    for (k in of) printf "| %s | %.2f | %.2f |\n", k, exp(sum[k] / of[k]), exp(one[k] / of[k])
    printf "| geometric mean | %.2f | %.2f |\n", exp(total / all), exp(alone / all)
  }'
