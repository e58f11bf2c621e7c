#!/usr/bin/env bash
# Counts the rays that tests compare bit for bit, for bench/README.md: tests.sh BUILD RESULTS writes RESULTS/tests.csv.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$1 results=$2
"$build/test" "the same bits every way" >"$build/tests.txt"
{
  "$build/provenance" make test
  echo what,rays,answers,differ
  awk '/ rays, .* answers, .* hits; .* differ; control/ {
      for (i = 2; i <= NF; i++) {
        if ($i == "rays,") rays += $(i - 1)
        if ($i == "answers,") answers += $(i - 1)
        if ($i == "differ;" && $(i - 1) ~ /^[0-9]+$/) differ += $(i - 1)
      }
      lines++
    }
    END { if (!lines) exit 1; printf "identity,%d,%d,%d\n", rays, answers, differ }' "$build/tests.txt"
} >"$build/tests.csv"
mv "$build/tests.csv" "$results/tests.csv"
