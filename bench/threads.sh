#!/usr/bin/env bash
# Compares N threads of one build/render with N copies of it that have a thread each: what the threads reach of what the
# copies do, for trees and for pictures, in the same time. Copies and threads take turns; the median of ROUNDS.
# usage: bench/threads.sh [N]     N: all processors of this machine unless told
set -u
n=${1:-$(nproc)} rounds=${ROUNDS:-7} work=build/bench-threads
mkdir -p "$work"

run() { # file, thread count, options of render: leaves "build seconds, render seconds"
  build/render "${@:3}" --threads "$2" --no-count --no-progress 2>/dev/null |
    sed -n 's/^seconds .*build \([0-9.]*\), render \([0-9.]*\).*/\1 \2/p' >"$1"
}

# What copies do in the same time is the sum of what each does, hence the harmonic mean of their times.
measure() { # name, options of render
  local name=$1 i
  shift
  for ((r = 0; r < rounds; r++)); do
    for ((i = 0; i < n; i++)); do run "$work/$i" 1 "$@" & done
    wait
    run "$work/one" "$n" "$@"
    cat $(seq -f "$work/%.0f" 0 $((n - 1))) "$work/one" |
      awk -v n="$n" 'NR <= n { b += 1 / $1; p += 1 / $2 } END { if (NR == n + 1) print 1 / (b * $1), 1 / (p * $2), $1, $2 }'
  done >"$work/rounds"
  [ "$(wc -l <"$work/rounds")" = "$rounds" ] || { echo "$name: some did not run"; exit 1; }
  for column in 1 2 3 4; do sort -n -k "$column,$column" "$work/rounds" | awk "NR == int(($rounds + 1) / 2) { print \$$column }"; done |
    tee -a "$work/all" | xargs printf "$name:  trees %.2f, pictures %.2f;  by threads %.3f s, %.3f s\n"
}

: >"$work/all"
make -s build/render || exit 1
echo "$n copies of one thread, one of $n threads: what threads reach of copies (pictures: 0.95, trees: 0.8)"
for scene in poolhall conference rtrt; do
  for mode in rcs wrt; do measure "$scene $mode 1024 x 768" --scene $scene --mode $mode --size 1024x768; done
done
measure "poolhall drt 512 x 384, 4" --scene poolhall --mode drt --size 512x384 --spp 4
awk '{ at = (NR - 1) % 4; s[at] += log($1); k[at]++ } END { printf "geometric mean:  trees %.2f, pictures %.2f\n", exp(s[0] / k[0]), exp(s[1] / k[1]) }' "$work/all"
