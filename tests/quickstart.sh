#!/bin/sh
# Takes the quick start out of the header's opening comment, builds it as C and as C++, and runs it.
# usage: quickstart.sh [header [directory]], from the project's directory
set -eu
header=${1:-pktrt.h} dir=${2:-build/quickstart}
mkdir -p "$dir"
cp "$header" "$dir/pktrt.h"
awk '/QUICK START \(compiles as is\)/ {on = 1; next} /END OF QUICK START/ {on = 0} on' "$header" >"$dir/quickstart.c"
[ -s "$dir/quickstart.c" ] || { echo "quickstart: no quick start in $header" >&2; exit 1; }
cd "$dir"
warnings="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror"
${CC:-cc} -std=c99 -O2 $warnings quickstart.c -o quickstart -lm
./quickstart
${CXX:-c++} -x c++ -std=c++11 -O0 $warnings quickstart.c -o quickstart-cpp -lm
./quickstart-cpp
echo "quick start: built and run as C and C++"
