#!/usr/bin/env bash
# What the implementation weighs: bytes of code and seconds to compile of six usual builds, beside examples/render.c without it.
#   weight.sh [--turns N] RESULTS
#                             writes RESULTS/weight.list and shows it
#   weight.sh --publish LIST  makes it the list in examples/manual.md, under "Weight"
#   weight.sh --before HEADER PROVENANCE RESULTS
#                             the same builds of another header, in turns: writes RESULTS/weight.csv and .md
#   weight.sh --check         fails where a build weighs more than the list says, or where a control of 3% more bytes or of three
#                             times the seconds is not noticed
# The list is of gcc 12 for x86-64 at -O2. A check compares bytes as ratios to those of examples/render.c, compiled in the same
# run, and allows 1.5%; seconds as ratios, too, and allows a third, since other work may run beside it.
set -euo pipefail
cd "$(dirname "$0")/.."
turns=3 check=''
[ "${1:-}" != --check ] || check=yes turns=1
[ "${1:-}" != --turns ] || { turns=$2; shift 2; }
work=build/weight
manual=examples/manual.md
mkdir -p $work
cc="${CC:-gcc} -std=c99 -O2 -w"
avx2=-DPKTRT_NO_SSE2
queries="$avx2 -DPKTRT_NO_RENDER"
barest="$queries"
for part in MOTION STATS PAPER INSTANCES GROUPS REMOVAL SURFACES POOLS CLOSEST NORMALS QUALITIES; do barest="$barest -DPKTRT_NO_$part"; done
names=(whole "AVX2 alone" "queries, AVX2" "barest queries, AVX2" "scalar" "with AVX-512")
flags=("" "$avx2" "$queries" "$barest" "-DPKTRT_NO_SIMD" "-DPKTRT_AVX512")

# The list in the manual: a heading, a row for each build, and what it is measured beside.
heading='| build | seconds | bytes of code |'
if [ "${1:-}" = --publish ]; then
  awk -v list="$2" -v heading="$heading" '
    $0 == heading {while ((getline line < list) > 0) print line; skip = 1}
    skip && /^[|]/ {next}
    {skip = 0; print}' $manual >$work/manual.md
  cmp -s $work/manual.md $manual || { cp $work/manual.md $manual && echo "published: the list of weights in $manual"; }
  exit
fi

compiler=$($cc -dumpversion | cut -d. -f1)
if ! $cc -v 2>&1 | grep -q '^gcc version' || [ "$compiler" != 12 ] || [ "$(uname -m)" != x86_64 ]; then
  echo "weight: the list is of gcc 12 for x86-64, this is another compiler: nothing is compared"
  exit 0
fi

bytes_of() { size "$1" | awk 'NR == 2 {print $1}'; }
compile() { # object, arguments...: prints the least seconds of all turns
  local object=$1 turn
  shift
  for ((turn = 0; turn < turns; turn++)); do
    { TIMEFORMAT=%U; time $cc "$@" -c -o "$object"; } 2>&1
  done | sort -g | head -1
}
beside() { compile $work/render.o -DPK_IMPLEMENTED -DPK_ENTRY_POINTS examples/render.c; }
build() { compile "$work/$1.o" ${flags[$1]} -DPKTRT_IMPLEMENTATION -x c pktrt.h; }

row() { printf '| %s | %.1f | %s |\n' "$1" "$2" "$(printf "%d" "$3" | sed -E ':a; s/([0-9])([0-9]{3})($|,)/\1,\2\3/; ta')"; }
listed() { # name: seconds and bytes
  awk -F ' *[|] *' -v heading="$heading" -v name="$1" '
    $0 == heading { inside = 1 }
    !/^[|]/ { inside = 0 }
    inside && $2 == name { gsub(",", ""); print $3, $4; exit }' $manual
}

# --- beside another header ---

if [ "${1:-}" = --before ]; then
  before=$2 provenance=$3 results=$4
  names+=("whole, -O0" "scalar, -O1, ASan and UBSan")
  flags+=("-O0" "-DPKTRT_NO_SIMD -O1 -fsanitize=address,undefined")
  commit=$(sed -n 's/^.*- v\([0-9.]*\) -.*/\1/p' "$before" | head -1)
  { "$provenance" make weight-before; echo "build,seconds_before,seconds,bytes_before,bytes"; } >"$results/weight.csv"
  {
    echo "Version $commit and this one: gcc 12, -O2 unless told, one core; the median of three turns in one run. A"
    echo "version with all instruction sets by default was asked for AVX2 alone where the name says so."
    echo
    echo "| build | bytes before | bytes now | seconds before | seconds now | now over before |"
    echo "|---|--:|--:|--:|--:|--:|"
  } >"$results/weight.md"
  for i in "${!names[@]}"; do
    [ "${names[i]}" != "with AVX-512" ] || continue
    more="${flags[i]}"
    case $more in *NO_SSE2*) more="$more -DPKTRT_NO_SCALAR -DPKTRT_NO_AVX512" ;; esac
    : >$work/before.s >$work/now.s
    turns=1
    for turn in 1 2 3; do
      compile $work/before.o $more -DPKTRT_IMPLEMENTATION -x c "$before" >>$work/before.s
      compile $work/now.o $more -DPKTRT_IMPLEMENTATION -x c pktrt.h >>$work/now.s
    done
    a=$(sort -g $work/before.s | sed -n 2p) b=$(sort -g $work/now.s | sed -n 2p)
    x=$(bytes_of $work/before.o) y=$(bytes_of $work/now.o)
    echo "\"${names[i]}\",$a,$b,$x,$y" >>"$results/weight.csv"
    awk -v n="${names[i]}" -v a="$a" -v b="$b" -v x="$x" -v y="$y" \
      'BEGIN {printf "| %s | %d | %d | %.1f | %.1f | %.2f |\n", n, x, y, a, b, b / a}' >>"$results/weight.md"
  done
  cat "$results/weight.md"
  exit
fi

seconds_beside=$(beside)
bytes_beside=$(bytes_of $work/render.o)
if [ -z "$check" ]; then
  {
    echo "$heading"
    echo "|---|--:|--:|"
    for i in "${!names[@]}"; do
      seconds=$(build "$i")
      row "${names[i]}" "$seconds" "$(bytes_of "$work/$i.o")"
    done
    row "examples/render.c" "$seconds_beside" "$bytes_beside"
  } >"$1/weight.list"
  cat "$1/weight.list"
  exit
fi

read -r was_seconds_beside was_bytes_beside <<<"$(listed examples/render.c)"
heavier() { # name, seconds, bytes: says so, and succeeds, if a build weighs more than listed
  local was_seconds was_bytes
  read -r was_seconds was_bytes <<<"$(listed "$1")"
  awk -v name="$1" -v s="$2" -v b="$3" -v ws="${was_seconds:-0}" -v wb="${was_bytes:-0}" -v rs="$seconds_beside" -v rb="$bytes_beside" \
    -v wrs="$was_seconds_beside" -v wrb="$was_bytes_beside" 'BEGIN {
      bytes = b / rb / (wb / wrb)
      seconds = s / rs / (ws / wrs)
      more = (bytes > 1.015 || seconds > 4 / 3)
      printf "weight: %s, beside examples/render.c: %.3f times the bytes listed, %.2f times the seconds%s\n", name, bytes, seconds,
             (more ? ": MORE" : "")
      exit !more}'
}
failed=0
for i in "${!names[@]}"; do
  seconds=$(build "$i")
  bytes=$(bytes_of "$work/$i.o")
  if heavier "${names[i]}" "$seconds" "$bytes"; then failed=1; fi
  if ! heavier "${names[i]}" "$seconds" $((bytes * 103 / 100)) >$work/control; then
    echo "weight: the control, 3% more of ${names[i]}, is not noticed"
    failed=1
  fi
  if ! heavier "${names[i]}" "$(awk "BEGIN {print 3 * $seconds}")" $((bytes * 95 / 100)) >$work/control; then
    echo "weight: the control, three times the seconds for ${names[i]}, is not noticed"
    failed=1
  fi
done
# Not optimised: no longer to compile, and less than 1.5 MB.
whole=$(compile $work/0.o -DPKTRT_IMPLEMENTATION -x c pktrt.h)
seconds=$(compile $work/slow.o -O0 -DPKTRT_IMPLEMENTATION -x c pktrt.h)
echo "weight: at -O0 $(bytes_of $work/slow.o) bytes in $seconds s, at -O2 in $whole s"
[ "$(bytes_of $work/slow.o)" -lt 1500000 ] && awk -v a="$seconds" -v b="$whole" 'BEGIN {exit !(a < b)}' || failed=1
[ $failed = 0 ] || echo "weight: find what made it so, or list the new weight by make weight bench-publish"
exit $failed
