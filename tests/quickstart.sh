#!/bin/sh
# Takes the quick start out of the header's opening comment, builds it as C and as C++, and runs it.
# usage: quickstart.sh [header [directory]], from the project's directory
set -eu
header=${1:-pktrt.h} dir=${2:-build/quickstart}
mkdir -p "$dir"
cp "$header" "$dir/pktrt.h"
awk '/QUICK START \(compiles as is\)/ {on = 1; next} /END OF QUICK START/ {on = 0} on' "$header" >"$dir/quickstart.c"
# The version of the first line, the newest of the changes and of the manual, and the macro.
first=$(sed -n '1s/.* v\([0-9.]*\) .*/\1/p' "$header")
newest=$(awk '/^\/\* >>changes/ {on = 1; next} on && NF {print $1; exit}' "$header")
manual=$(dirname "$header")/examples/manual.md
listed=$newest
[ ! -e "$manual" ] || listed=$(awk '/^## Versions/ {on = 1} on && match($0, /^(- )?[0-9]+\.[0-9]+\.[0-9]+/) {sub(/^- /, ""); sub(/[^0-9.].*/, ""); sub(/\.$/, ""); print; exit}' "$manual")
macro=$(awk '/^#define PKTRT_VERSION/ {printf "%d.%d.%d", $3 / 10000, $3 / 100 % 100, $3 % 100}' "$header")
[ "$first" = "$newest" ] && [ "$first" = "$macro" ] && [ "$first" = "$listed" ] ||
  { echo "quickstart: versions differ in $header: $first, $newest, PKTRT_VERSION $macro, manual $listed" >&2; exit 1; }
[ -s "$dir/quickstart.c" ] || { echo "quickstart: no quick start in $header" >&2; exit 1; }
cd "$dir"
warnings="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"
${CC:-cc} -std=c99 ${CFLAGS:--O1} $warnings quickstart.c -o quickstart -lm &
${CXX:-c++} -x c++ -std=c++11 ${CFLAGS:--O0} $warnings quickstart.c -o quickstart-cpp -lm
wait $!
./quickstart
./quickstart-cpp
echo "quick start: built and run as C and C++"
