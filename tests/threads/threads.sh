#!/usr/bin/env bash
# Looks after examples/threads.h: tests/threads/program.c by pthreads, natively and under TSan, and by Win32, compiled by
# MinGW and run under wine. What is not installed is said in a line; MATRIX_ALL=1 makes it an error.
# usage: tests/threads/threads.sh BUILD
set -u
work=$1/test-threads
mkdir -p "$work"
strict="-std=c99 -ffp-contract=off -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -I."
bad=0

lacks() {
  echo "skipped: $1 is not installed (make deps-extra installs it)"
  [ -z "${MATRIX_ALL:-}" ] || bad=1
}
# shellcheck disable=SC2086
compile() { "$1" $strict "${@:3}" tests/threads/program.c -o "$2" -lm || { echo "FAILED: $1 does not compile it"; bad=1; return 1; }; }

compile "${CC:-cc}" "$work/program" -O2 -pthread && { echo "by pthreads:" && "$work/program" || bad=1; }

if command -v clang >/dev/null; then
  compile clang "$work/tsan" -O1 -g -fsanitize=thread -DPKTRT_NO_SIMD -pthread &&
    { echo "by pthreads, under TSan:" && "$work/tsan" || bad=1; }
else
  lacks clang
fi

compiler=x86_64-w64-mingw32-gcc
wine=$(command -v wine64 || command -v wine || echo /usr/lib/wine/wine64)
if command -v $compiler >/dev/null && [ -x "$wine" ]; then
  export WINEPREFIX=$PWD/$work/wine WINEDEBUG=-all WINEDLLOVERRIDES='mscoree,mshtml='
  "$wine" wineboot -i >"$work/wine.txt" 2>&1
  compile $compiler "$work/program.exe" -O2 -static && { echo "by Win32 (MinGW, wine):" && "$wine" "$work/program.exe" || bad=1; }
  "$wine" wineboot -k >>"$work/wine.txt" 2>&1
else
  lacks "$compiler or wine"
fi
[ $bad = 0 ] && echo "threads: all passed"
exit $bad
