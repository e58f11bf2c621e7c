#!/usr/bin/env bash
# PKTRT_STATIC and PKTRT_DEF: what is exported, and which contradictions are an #error.
# usage: linkage.sh [header], from the project's directory
set -u
header=$(readlink -f "${1:-pktrt.h}") work=build/linkage
mkdir -p $work
. tests/attempt.sh
excerpt() { head -6; }
options=("-DHEADER=\"$header\"" "-DPKTRT_HEADER_FILENAME=HEADER" -Wall -Wextra -Wpedantic -Werror)
small=(-O0 -DPKTRT_NO_RENDER -DPKTRT_NO_SIMD -DPKTRT_NO_MOTION -DPKTRT_NO_PAPER -DPKTRT_NO_STATS) # what is exported does not depend on what there is

printf '#define PKTRT_IMPLEMENTATION\n#include HEADER\n' >$work/all.c
printf '#include HEADER\n#define PKTRT_STATIC\n#define PKTRT_IMPLEMENTATION\n#include HEADER\n' >$work/late.c
printf '#define PKTRT_STATIC\n#include HEADER\n#undef PKTRT_STATIC\n#define PKTRT_IMPLEMENTATION\n#include HEADER\n' >$work/withdrawn.c
printf '#define PKTRT_STATIC\n#include HEADER\n#define PKTRT_IMPLEMENTATION\n#include HEADER\n' >$work/early.c
cat >$work/user.c <<'C'
#include HEADER
int main(void) { return pktrt_isa_available(PKTRT_ISA_AUTO) ? 0 : 1; }
C

refused() { # words of the #error, command...
  local words=$1 out
  shift
  out=$("$@" 2>&1) && { echo "it compiles"; return 1; }
  printf '%s\n' "$out" | grep '#error' | grep -qF "$words" || { printf '%s\n' "$out"; return 1; }
}
exports() { # how many, file: of the functions of the API, from the library's table
  local n
  n=$(nm -D --defined-only "$2" | grep -c ' T pktrt_[a-z]')
  [ "$n" = "$1" ] || { echo "$n functions are exported, expected $1"; return 1; }
}
exports_all() { # file
  local n
  n=$(nm $work/hidden.so | grep -c ' t pktrt_[a-z]')
  [ "$n" -gt 20 ] && exports "$n" "$1"
}
shared() { # name, command...: a library whose functions are hidden unless they say otherwise
  local name=$1
  shift
  "$@" "${options[@]}" "${small[@]}" -fvisibility=hidden -shared -fPIC $work/all.c -o "$work/$name" -lm
}

for compiler in "gcc -std=c99" "clang -std=c99" "g++ -x c++ -std=c++11" "clang++ -x c++ -std=c++11"; do
  have "${compiler%% *}" || continue
  # shellcheck disable=SC2086
  set -- $compiler
  rm -f $work/*.so $work/user
  attempt "$1: PKTRT_STATIC defined late is an #error" refused 'PKTRT_STATIC: define it before' "$@" "${options[@]}" -fsyntax-only $work/late.c
  attempt "$1: withdrawn too" refused 'PKTRT_STATIC: define it before' "$@" "${options[@]}" -fsyntax-only $work/withdrawn.c
  for switch in RENDER NORMALS REMOVAL INSTANCES SURFACES; do
    sed "s/PKTRT_STATIC/PKTRT_NO_$switch/" $work/late.c >$work/switch.c
    attempt "$1: PKTRT_NO_$switch, too" refused "PKTRT_NO_$switch: define it before" "$@" "${options[@]}" -fsyntax-only $work/switch.c
  done
  attempt "$1: in time it is none" "$@" "${options[@]}" "${small[@]}" -fsyntax-only $work/early.c
  attempt "$1: PKTRT_STATIC beside PKTRT_DEF is an #error" refused 'define only one of them' \
    "$@" "${options[@]}" -DPKTRT_STATIC -DPKTRT_DEF=extern -fsyntax-only $work/all.c
  attempt "$1: a library with PKTRT_DEF is built" shared public.so "$@" '-DPKTRT_DEF=__attribute__((visibility("default")))'
  attempt "$1: a library without is built" shared hidden.so "$@"
  attempt "$1: control: it exports nothing" exports 0 $work/hidden.so
  attempt "$1: the other exports the API" exports_all $work/public.so
  attempt "$1: a program uses it" "$@" "${options[@]}" -DPKTRT_NO_RENDER $work/user.c -x none $work/public.so -o $work/user "-Wl,-rpath,$PWD/$work"
  attempt "$1: and runs" $work/user
done

dll_exports() { # how many
  local n
  n=$(x86_64-w64-mingw32-objdump -p $work/pktrt.dll | grep -c '\] pktrt_[a-z]')
  [ "$n" = "$1" ] || { echo "$n functions are exported, expected $1"; return 1; }
}
dll_exports_all() { dll_exports "$(nm $work/hidden.so | grep -c ' t pktrt_[a-z]')"; }
for compiler in "x86_64-w64-mingw32-gcc -std=c99" "x86_64-w64-mingw32-g++ -x c++ -std=c++11"; do
  have "${compiler%% *}" || continue
  # shellcheck disable=SC2086
  set -- $compiler
  rm -f $work/pktrt.dll $work/user.exe
  # One function of the file is exported in any case: then a linker exports no others by itself.
  printf '#define PKTRT_IMPLEMENTATION\n#include HEADER\n#ifdef __cplusplus\nextern "C"\n#endif\n__declspec(dllexport) int other(void);\nint other(void) { return 1; }\n' >$work/dll.c
  attempt "$1: a library without PKTRT_DEF is built" "$@" "${options[@]}" "${small[@]}" -shared $work/dll.c -o $work/pktrt.dll
  attempt "$1: control: it does not export the API" dll_exports 0
  attempt "$1: a library with dllexport is built" "$@" "${options[@]}" "${small[@]}" '-DPKTRT_DEF=__declspec(dllexport)' -shared $work/dll.c -o $work/pktrt.dll
  attempt "$1: it exports the API" dll_exports_all
  attempt "$1: a program with dllimport links it" "$@" "${options[@]}" -DPKTRT_NO_RENDER '-DPKTRT_DEF=__declspec(dllimport)' $work/user.c -x none $work/pktrt.dll -o $work/user.exe
done

echo "linkage: $passed passed, $failed failed; $skipped compilers skipped"
[ $passed -gt 0 ] && [ $failed = 0 ] && { [ $skipped = 0 ] || [ -z "${MATRIX_ALL:-}" ]; }
