#!/usr/bin/env bash
# The header, implementation and all, behind macros of others: a list of hostile ones (tests/hostile.h) and the real headers that
# have many, each where it is installed. usage: hostile.sh [header], from the project's directory
set -u
header=$(readlink -f "${1:-pktrt.h}") work=build/hostile
mkdir -p $work
warnings="-Wall -Wextra -Wpedantic -Werror -fsyntax-only"
. tests/attempt.sh
excerpt() { grep -m 6 'error\|warning'; }

# What the header itself includes comes first, for that is not its own.
cat >$work/list.c <<'C'
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif
#include "../../tests/hostile.h"
#define PKTRT_AVX512
#define PKTRT_SCALAR
#define PKTRT_IMPLEMENTATION
#include HEADER
C
# Macros that a program has itself are still there afterwards, and still its own.
cat >$work/own.c <<'C'
#define NAME(x) x##_of_mine
#define COUNT 3
#define VOP 5
#define STEP 7
#define UNROLL 11
#define FRUSTUM_WIDTH 13
#define INSTANCE 17
#define PKTRT_IMPLEMENTATION
#include HEADER
typedef char NAME(still)[COUNT * VOP * STEP * UNROLL * FRUSTUM_WIDTH * INSTANCE == 3 * 5 * 7 * 11 * 13 * 17 ? 1 : -1];
C
printf '#include <%s>\n' complex.h tgmath.h math.h >$work/tgmath.c
printf '#include <%s>\n' X11/Xlib.h X11/Xutil.h X11/keysym.h >$work/x11.c
printf '#include <%s>\n' curses.h >$work/curses.c
printf '#include <%s>\n' termios.h sys/socket.h sys/stat.h sys/sysmacros.h netdb.h signal.h unistd.h >$work/posix.c
printf '#include <%s>\n' windows.h >$work/windows.c
printf '#include <%s>\n' winsock2.h windows.h windowsx.h commctrl.h objbase.h shlobj.h mmsystem.h d3d11.h GL/gl.h >$work/windows_all.c
for name in tgmath x11 curses posix windows windows_all; do
  printf '#define PKTRT_IMPLEMENTATION\n#include HEADER\n' | cat $work/$name.c - >$work/with_$name.c
done

behind() { # file, compiler...: skipped where the compiler has not got what the file includes
  local name=$1 what="$2 ${*: -1}, $1"
  shift
  if ! command -v "$1" >/dev/null; then echo "skipped: $1 is not installed (make deps-extra)"; skipped=$((skipped + 1)); return; fi
  if [ "$name" != list ] && [ "$name" != own ] && ! "$@" -fsyntax-only $work/"$name".c 2>/dev/null; then
    echo "skipped: $what has not got these headers"
    return
  fi
  [ ! -e $work/with_"$name".c ] || name=with_$name
  # shellcheck disable=SC2086
  attempt "$what" "$@" $warnings "-DHEADER=\"$header\"" "-DPKTRT_HEADER_FILENAME=\"$header\"" $work/"$name".c
}

for compiler in "gcc -std=gnu99" "clang -std=c99" "g++ -x c++ -std=c++11" "clang++ -x c++ -std=c++11"; do
  # shellcheck disable=SC2086
  for name in list own; do behind $name $compiler; done
done
for name in x11 curses posix; do behind $name gcc -std=gnu99; done
behind tgmath gcc -std=gnu2x
behind tgmath clang -std=gnu11
for name in windows windows_all; do
  behind $name x86_64-w64-mingw32-gcc -std=gnu99
  behind $name x86_64-w64-mingw32-g++ -x c++ -std=gnu++11
done

# The control: a name of the list in the header is noticed.
sed 's/^static void pk_log_sentence(.*{$/&\n  int near = level; (void)near;/' "$header" >$work/near.h
grep -q 'int near' $work/near.h || { echo "FAILED  the control was not made"; failed=$((failed + 1)); }
attempt "control: a header that says near" fails gcc -std=gnu99 -fsyntax-only "-DHEADER=\"near.h\"" "-DPKTRT_HEADER_FILENAME=\"near.h\"" $work/list.c

echo "hostile: $passed passed, $failed failed; $skipped compilers skipped"
[ $passed -gt 0 ] && [ $failed = 0 ] && { [ $skipped = 0 ] || [ -z "${MATRIX_ALL:-}" ]; }
