#!/usr/bin/env bash
# What `make install` puts, and programs that find it: by pkg-config, and by the lines for CMake that the README has, as C and as
# C++; and one program with several copies of the header, of different versions. All in folders whose names have blanks.
# usage: install.sh, from the project's directory
set -u
unset MAKEFLAGS MAKELEVEL MFLAGS DESTDIR PREFIX CFLAGS CXXFLAGS LDFLAGS # of the make that runs this
work=build/install
rm -rf $work
root="$PWD/$work/with two blanks"
mkdir -p "$root"
CC=${CC:-cc} CXX=${CXX:-c++}
. tests/attempt.sh
warnings=(-Wall -Wextra -Wpedantic -Werror)
small=(-O0 -DPKTRT_NO_RENDER -DPKTRT_NO_SIMD -DPKTRT_NO_MOTION -DPKTRT_NO_PAPER -DPKTRT_NO_STATS -DPKTRT_NO_INSTANCES
  -DPKTRT_NO_GROUPS -DPKTRT_NO_REMOVAL -DPKTRT_NO_SURFACES -DPKTRT_NO_CLOSEST
  -DPKTRT_NO_FRUSTA) # where it is found does not depend on what it has
version=$(awk '/^#define PKTRT_VERSION/ {print $3}' pktrt.h)

clashes() { "$@" 2>&1 | grep -i 'multiple definition\|duplicate symbol'; } # command...: a linker's complaint
says() { # words, command...
  local words=$1 out
  shift
  out=$("$@") && [ "$out" = "$words" ] || { echo "it says \"$out\", expected \"$words\""; return 1; }
}

# --- what is put, and taken away ---

# The tools that it needs and no others: no compiler among them.
mkdir -p $work/tools
for tool in sh make awk install rm; do ln -s "$(readlink -f "$(command -v $tool)")" $work/tools/$tool; done
with_few_tools() { PATH="$PWD/$work/tools" make --no-print-directory "$@"; }
files() { (cd "$1" && find . ! -type d | LC_ALL=C sort); } # folder
puts_two_files() { # folder, arguments of make: two files more than before, which all may read, whatever the umask
  local folder=$1 before
  shift
  before=$(files "$folder")
  (umask 077 && with_few_tools install "$@") || return 1
  # shellcheck disable=SC2086
  says "$(printf '%s\n' $before ./include/pktrt.h ./share/pkgconfig/pktrt.pc | LC_ALL=C sort)" files "$folder" &&
    cmp pktrt.h "$folder/include/pktrt.h" &&
    says '' find "$folder/include" "$folder/share" ! -perm -o=r
}
takes_them_away() { # folder, what is to be left, arguments of make
  local folder=$1 left=$2
  shift 2
  with_few_tools uninstall "$@" && says "$left" files "$folder"
}
stage="$root/it's staged" prefix="/opt/tools of mine"
mkdir -p "$stage$prefix/include" "$stage$prefix/share/pkgconfig"
touch "$stage$prefix/include/pktrt_of_others.h" "$stage$prefix/share/pkgconfig/other.pc"
others=$(files "$stage$prefix")
attempt "install puts header and pkg-config file below DESTDIR and PREFIX" puts_two_files "$stage$prefix" DESTDIR="$stage" PREFIX="$prefix"
attempt "and again, over itself" with_few_tools install DESTDIR="$stage" PREFIX="$prefix"
attempt "uninstall takes these two away, and what others put stays" takes_them_away "$stage$prefix" "$others" DESTDIR="$stage" PREFIX="$prefix"
mkdir -p "$root/first"
attempt "install without DESTDIR" puts_two_files "$root/first" PREFIX="$root/first"
mv "$root/first" "$root/my tools"

# --- programs ---

cat >"$root/main.c" <<'C'
#define PKTRT_IMPLEMENTATION
#include <pktrt.h>
#include "hit.h"
int main(void) {
  printf("%u %g\n", (unsigned)pktrt_version(), (double)hit());
  return 0;
}
C
cat >"$root/hit.h" <<'C'
#include <math.h>
#include <stdio.h>
static float hit(void) { /* a triangle two above the origin */
  static const float corners[] = {-1, 2, -1, 1, 2, -1, 0, 2, 1};
  static pktrt_mesh_desc mesh;
  mesh.positions = corners, mesh.vertex_count = 3, mesh.triangle_count = 1;
  pktrt_scene *scene = pktrt_scene_create(NULL);
  const pktrt_ray ray = {{0, 0, 0}, 0, {0, 1, 0}, INFINITY, 0};
  pktrt_hit found;
  found.t = -1;
  if (scene && !pktrt_add_mesh(scene, &mesh, NULL) && !pktrt_commit(scene)) pktrt_intersect(scene, &ray, &found);
  pktrt_scene_destroy(scene);
  return found.t;
}
C
cp "$root/main.c" "$root/main.cpp"

# pkg-config escapes blanks, hence eval.
by_pkg_config() { # program, compiler and source...
  local program=$1
  shift
  PKG_CONFIG_PATH="$root/my tools/share/pkgconfig"
  export PKG_CONFIG_PATH
  eval '"$@" "${warnings[@]}" "${small[@]}" -o "$program"' "$(pkg-config --cflags --libs pktrt)" && says "$version 2" "$program"
}
says_its_version() {
  says "$(awk -v v="$version" 'BEGIN {printf "%d.%d.%d", v / 10000, v / 100 % 100, v % 100}')" \
    env PKG_CONFIG_PATH="$root/my tools/share/pkgconfig" pkg-config --modversion pktrt
}
if have pkg-config; then
  attempt "pkg-config tells the header's version, after the folder has moved" says_its_version
  attempt "pkg-config: a C program" by_pkg_config "$root/by pkg-config" "$CC" -std=c99 "$root/main.c"
  have "$CXX" && attempt "pkg-config: a C++ program" by_pkg_config "$root/by pkg-config++" "$CXX" -std=c++11 "$root/main.cpp"
fi

project="$root/a project"
by_cmake() {
  cmake -S "$project" -B "$project/build" -DCMAKE_C_COMPILER="$CC" -DCMAKE_CXX_COMPILER="$CXX" \
    -DCMAKE_C_FLAGS="${small[*]}" -DCMAKE_CXX_FLAGS="${small[*]}" >"$project/said" || { tail -5 "$project/said"; return 1; }
  cmake --build "$project/build" --parallel 2 >"$project/said" && says "$version 2" "$project/build/in_c" &&
    says "$version 2" "$project/build/in_cpp"
}
if have cmake "$CXX"; then
  mkdir -p "$project/pktrt"
  cp pktrt.h "$project/pktrt/"
  cp "$root"/main.c "$root"/main.cpp "$root"/hit.h "$project/"
  lines=$(awk '/^```cmake$/ {on = 1; next} /^```$/ {on = 0} on' README.md)
  attempt "the README has three lines for CMake" [ "$(wc -l <<<"$lines")" = 3 ]
  cat >"$project/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.10)
project(a_project C CXX)
$lines
add_executable(in_c main.c)
add_executable(in_cpp main.cpp)
target_link_libraries(in_c PRIVATE pktrt)
target_link_libraries(in_cpp PRIVATE pktrt)
CMAKE
  attempt "CMake: by the README's lines, a C and a C++ program" by_cmake
fi

# --- several in one program ---

# One library has a static copy, one hides its implementation, and a third shows it to the program. Each has a version of its own,
# which it tells, so that one sees who calls whom.
for name in a b; do
  mkdir -p "$root/version $name"
  sed "s/^\(#define PKTRT_VERSION\) [0-9]*/\1 $([ $name = a ] && echo 1 || echo 2)/" pktrt.h >"$root/version $name/pktrt.h"
  cat >"$root/$name.c" <<C
$([ $name = a ] && echo '#define PKTRT_STATIC')
#define PKTRT_IMPLEMENTATION
#include <pktrt.h>
#include "hit.h"
#ifdef __cplusplus
extern "C"
#endif
__attribute__((visibility("default"))) float ${name}_says(void);
float ${name}_says(void) { return (float)pktrt_version() + hit() / 4; }
C
done
printf '#define PKTRT_IMPLEMENTATION\n#include <pktrt.h>\n' >"$root/c.c"
cat >"$root/all.c" <<'C'
#include <pktrt.h>
#include "hit.h"
float a_says(void), b_says(void);
int main(void) {
  printf("%g %g %u %g\n", (double)a_says(), (double)b_says(), (unsigned)pktrt_version(), (double)hit());
  return 0;
}
C
object() { # object, folder of the header, compiler and source...
  local object=$1 folder=$2
  shift 2
  "$@" "${warnings[@]}" "${small[@]}" -fPIC "-I$root/$folder" -c -o "$root/$object"
}
objects() {
  object a.o "version a" "$CC" -std=c99 "$root/a.c" & a=$!
  object b.o "version b" "$CXX" -std=c++11 -fvisibility=hidden -x c++ "$root/b.c" & b=$!
  wait $a && wait $b || return 1
  object seen_b.o "version b" "$CC" -std=c99 "$root/b.c" & a=$!
  object c.o "my tools/include" "$CC" -std=c99 "$root/c.c" & b=$!
  wait $a && wait $b && object all.o "my tools/include" "$CC" -std=c99 "$root/all.c"
}
libraries() {
  local name
  for name in a seen_b c; do "$CC" -shared "$root/$name.o" -o "$root/lib$name.so" -lm || return 1; done
  "$CXX" -shared "$root/b.o" -o "$root/libb.so" -lm
}
program() { # name, libraries or objects...: the program, and where the libraries are at run time
  local name=$1
  shift
  (cd "$root" && "$CC" all.o "$@" -o "$name" "-Wl,-rpath,$root" -lm)
}
exports() { # how many functions of the API, library
  says "$1" sh -c 'nm -D --defined-only "$1" | grep -c " [A-Z] pktrt"; :' sh "$root/$2"
}
together="1.5 2.5 $version 2"
if have "$CXX"; then
  attempt "three files that hold the implementation, of three versions, compile" objects
  attempt "they become shared libraries" libraries
  attempt "that with a static copy exports nothing of it" exports 0 liba.so
  attempt "nor does that which hides its implementation" exports 0 libb.so
  attempt "control: the third exports it" fails exports 0 libc.so
  attempt "a program links all three" program shared libc.so liba.so libb.so
  attempt "each calls its own version" says "$together" "$root/shared"
  attempt "in another order, too" program order libb.so liba.so libc.so
  attempt "likewise" says "$together" "$root/order"
  attempt "control: with a library that does not hide it" program clash libc.so liba.so libseen_b.so
  attempt "control: there one is called for the other" says "1.5 $version.5 $version 2" "$root/clash"
  attempt "a static copy is linked into the program beside the implementation" program objects a.o c.o libb.so
  attempt "each calls its own version" says "$together" "$root/objects"
  attempt "control: a second implementation is not" clashes program twice a.o c.o seen_b.o
fi

echo "install: $passed passed, $failed failed; $skipped skipped"
[ $passed -gt 0 ] && [ $failed = 0 ] && { [ $skipped = 0 ] || [ -z "${MATRIX_ALL:-}" ]; }
