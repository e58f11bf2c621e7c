#!/usr/bin/env bash
# Compares N threads of one build/render with N copies of it that have a thread each: what the threads reach of what the
# copies do, for trees and for pictures, in the same time. Copies and threads take turns; of each the best of ROUNDS.
# usage: bench/threads.sh [N]     N: all processors of this machine unless told
set -u
n=${1:-$(nproc)} rounds=${ROUNDS:-7} work=build/bench-threads
mkdir -p "$work"

run() { # file, thread count, options of render: leaves "build seconds, render seconds"
  build/render "${@:3}" --threads "$2" --no-count --no-progress 2>/dev/null |
    sed -n 's/^seconds .*build \([0-9.]*\), render \([0-9.]*\).*/\1 \2/p' >"$1"
}

# The slowest copy counts: all the others' work is done by then, too.
measure() { # name, options of render
  local name=$1 i
  shift
  : >"$work/copies"
  : >"$work/threads"
  for ((r = 0; r < rounds; r++)); do
    for ((i = 0; i < n; i++)); do run "$work/$i" 1 "$@" & done
    wait
    cat $(seq -f "$work/%.0f" 0 $((n - 1))) | awk '{ if ($1 > b) b = $1; if ($2 > p) p = $2 } END { print b, p }' >>"$work/copies"
    run "$work/one" "$n" "$@"
    cat "$work/one" >>"$work/threads"
  done
  awk -v name="$name" -v n="$n" 'NR == 1 || $1 < b[FILENAME] || !b[FILENAME] { b[FILENAME] = $1 }
    !p[FILENAME] || $2 < p[FILENAME] { p[FILENAME] = $2 }
    END { c = ARGV[1]; t = ARGV[2]
      printf "%-28s build %.3f s, by threads %.3f: %.2f    picture %.3f s, by threads %.3f: %.2f\n", name, b[c], b[t],
        b[c] / b[t] / n, p[c], p[t], p[c] / p[t] / n }' "$work/copies" "$work/threads"
}

make -s build/render || exit 1
echo "$n copies of one thread, one of $n threads: seconds, and what threads reach of copies (pictures: 0.95, trees: 0.8)"
for scene in poolhall conference rtrt; do
  for mode in rcs wrt; do measure "$scene $mode 1024 x 768" --scene $scene --mode $mode --size 1024x768; done
done
measure "poolhall drt 512 x 384, 4" --scene poolhall --mode drt --size 512x384 --spp 4
