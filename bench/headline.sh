#!/usr/bin/env bash
# Measures the one table of figures of the README: headline.sh BUILD RESULTS writes RESULTS/headline.csv. Rays of the three built-in
# scenes are raced with Embree on one core, at rest and moving; then pictures are drawn, of which the pool hall's are in the table.
# It takes ten minutes. BENCH_ARGS="--size 64 --rounds 1" SIZE=64x64 SIZE_DRT=16x16 try it in small.
# With FROM=DIRECTORY nothing is measured: the rows are those of DIRECTORY/peers.csv, and of DIRECTORY/pictures.csv if both files
# are from the same version and machine.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$1 results=$2
work=$build/headline
mkdir -p "$work"

if [ -z "${FROM:-}" ]; then
  # shellcheck disable=SC2086
  "$build/peers" --settings rest,moving,refitted --isa avx512,avx2 --rounds 5 --no-robust --scenes conference,rtrt,poolhall \
    --results "$work" ${BENCH_ARGS:-} >"$work/peers.txt"
  bench/pictures.sh "$build" "$work"
fi
from=${FROM:-$work}

origin_of() { sed -n '1s/; date .*//p' "$1"; } # version and machine of a file of results
# Geometric means over the built-in scenes by the widest instruction set of the file: Mrays/s of Embree's fastest mode and of
# pktrt's calls for many rays, their ratio, that of single calls, and that where things move. Builds and refits are in ms.
rows_of_rays() {
  awk -F, '
    function better(key, value, least) { if (!(key in best) || (least ? value < best[key] : value > best[key])) best[key] = value }
    function mean(name, what,    i, n, sum) {
      for (i = 1; i <= scenes; i++) if ((isa, scene[i], name, what) in best) { n++; sum += log(best[isa, scene[i], name, what]) }
      return n ? sprintf("%.4g", exp(sum / n)) : ""
    }
    $2 != "built-in" || $3 == 0 { next }
    !($1 in seen) { seen[$1] = 1; scene[++scenes] = $1 }
    isa == "" || $5 == "avx512" { isa = $5 }
    $4 ~ /^moving/ && $8 == "ratio" && ($9 == "many" || $9 == "time") { better($5 SUBSEP $1 SUBSEP "moving" SUBSEP $6, $12) }
    $4 != ($6 == "refit" ? "refitted 1%" : "at rest") { next }
    $8 == "ratio" && ($9 == "many" || $9 == "time") { better($5 SUBSEP $1 SUBSEP "ratio" SUBSEP $6, $12) }
    $8 == "ratio" && $9 == "single" { better($5 SUBSEP $1 SUBSEP "single" SUBSEP $6, $12) }
    $9 ~ /robust/ || $10 !~ /^(Mrays\/s|ms)$/ || ($8 == "pktrt" && $9 !~ /^(_n|_soa|time)$/) { next }
    { unit[$6] = $10; better($5 SUBSEP $1 SUBSEP $8 SUBSEP $6, $12, $10 == "ms") }
    END {
      n = split("primary shadow shadow-from-light mirror second-mirror diffuse ao build refit", kind, " ")
      for (k = 1; k <= n; k++)
        if (kind[k] in unit)
          printf "%s,%s,%s,%s,%s,%s,%s\n", kind[k], unit[kind[k]], mean("Embree", kind[k]), mean("pktrt", kind[k]),
            mean("ratio", kind[k]), mean("single", kind[k]), mean("moving", kind[k])
    }' "$1"
}
rows_of_pictures() {
  awk -F, '
    $1 == "poolhall" && $7 == 1 {
      printf "pool hall %s %dx%d%s,s,,%s,,,\n", $2, $3, $4, ($5 > 1 ? " with " $5 " samples" : ""), $11
    }' "$1"
}

{
  if [ -z "${FROM:-}" ]; then
    "$build/provenance" make bench-headline ${BENCH_ARGS:+"BENCH_ARGS=\"$BENCH_ARGS\""} \
      ${SIZE:+SIZE=$SIZE} ${SIZE_DRT:+SIZE_DRT=$SIZE_DRT}
  else
    head -1 "$from/peers.csv"
  fi
  echo what,unit,embree,pktrt,ratio,single,moving
  rows_of_rays "$from/peers.csv"
  if [ "$(origin_of "$from/peers.csv")" = "$(origin_of "$from/pictures.csv")" ]; then rows_of_pictures "$from/pictures.csv"; fi
} >"$work/headline.csv"
mv "$work/headline.csv" "$results/headline.csv"
