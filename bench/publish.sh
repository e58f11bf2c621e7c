#!/usr/bin/env bash
# Publishes what has been measured.
#   publish.sh RESULTS         moves the files of RESULTS to bench/results, and writes the tables of the READMEs and the list of
#                              weights in examples/manual.md anew
#   publish.sh --look RESULTS  writes the READMEs that this would make to out/readmes; no tracked file changes
# The tables of a README stand between the marks <!-- NAME --> and <!-- /NAME -->; bench/readme.awk fills them in.
set -euo pipefail
cd "$(dirname "$0")/.."
shopt -s nullglob
look=''
[ "$1" != --look ] || { look=yes; shift; }
results=$1
kept=bench/results
readmes=(README.md bench/README.md bench/*/README.md)
measured=("$results"/*.csv "$results"/*.md "$results"/*.svg)

fill_in() { # folder with the files of tables, folder for READMEs
  local file
  for file in "${readmes[@]}"; do
    mkdir -p "$2/$(dirname "$file")"
    awk -v results="$1" -f bench/readme.awk "$file" >"$2/$file"
  done
}

if [ -n "$look" ]; then
  # The files that are kept, with those of the same names that were measured since in their place.
  files=build/publish
  rm -rf $files out/readmes
  mkdir -p $files
  cp $kept/* $files
  [ ${#measured[@]} = 0 ] || [ "$results" -ef $kept ] || cp "${measured[@]}" $files
  fill_in $files out/readmes
  echo "$results has what was measured, out/readmes the READMEs with these figures; make bench-publish makes them those of the project"
  exit
fi

if ! [ "$results" -ef $kept ]; then
  for file in ${measured[@]+"${measured[@]}"}; do
    cmp -s "$file" "$kept/${file##*/}" || echo "published: $kept/${file##*/}"
    mv "$file" $kept
  done
fi
if [ -s "$results/weight.list" ]; then
  bench/weight.sh --publish "$results/weight.list"
  rm "$results/weight.list"
fi
mkdir -p build/publish
fill_in $kept build/publish
for file in "${readmes[@]}"; do
  cmp -s "build/publish/$file" "$file" || { cp "build/publish/$file" "$file" && echo "published: $file"; }
done
