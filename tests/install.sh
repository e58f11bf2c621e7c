#!/usr/bin/env bash
# What `make install` puts, and programs that find it: by pkg-config, and by what the manual says of CMake (FetchContent,
# find_package, add_subdirectory), as C and as C++; Debug programs whose implementation is optimised, and sanitizers, by the
# manual's lines; and one program with several copies of the header, of different versions. All in folders whose names have blanks.
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
  -DPKTRT_NO_GROUPS -DPKTRT_NO_REMOVAL -DPKTRT_NO_SURFACES -DPKTRT_NO_POOLS -DPKTRT_NO_CLOSEST -DPKTRT_NO_QUALITIES
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
for tool in sh make awk install rm rmdir; do ln -s "$(readlink -f "$(command -v $tool)")" $work/tools/$tool; done
with_few_tools() { PATH="$PWD/$work/tools" make --no-print-directory "$@"; }
files() { (cd "$1" && find . ! -type d | LC_ALL=C sort); } # folder
puts_four_files() { # folder, arguments of make: four files more than before, which all may read, whatever the umask
  local folder=$1 before
  shift
  before=$(files "$folder")
  (umask 077 && with_few_tools install "$@") || return 1
  # shellcheck disable=SC2086
  says "$(printf '%s\n' $before ./include/pktrt.h ./share/pkgconfig/pktrt.pc ./lib/cmake/pktrt/pktrtConfig{,Version}.cmake |
    LC_ALL=C sort)" files "$folder" && cmp pktrt.h "$folder/include/pktrt.h" && says '' find "$folder"/* ! -perm -o=r
}
takes_them_away() { # folder, what is to be left, arguments of make
  local folder=$1 left=$2
  shift 2
  with_few_tools uninstall "$@" && says "$left" files "$folder" && [ ! -e "$folder/lib/cmake/pktrt" ]
}
stage="$root/it's staged" prefix="/opt/tools of mine"
mkdir -p "$stage$prefix/include" "$stage$prefix/share/pkgconfig"
touch "$stage$prefix/include/pktrt_of_others.h" "$stage$prefix/share/pkgconfig/other.pc"
others=$(files "$stage$prefix")
attempt "install puts header and files for pkg-config and CMake below DESTDIR and PREFIX" puts_four_files "$stage$prefix" DESTDIR="$stage" PREFIX="$prefix"
attempt "and again, over itself" with_few_tools install DESTDIR="$stage" PREFIX="$prefix"
attempt "uninstall takes these four away, and what others put stays" takes_them_away "$stage$prefix" "$others" DESTDIR="$stage" PREFIX="$prefix"
mkdir -p "$root/first"
attempt "install without DESTDIR" puts_four_files "$root/first" PREFIX="$root/first"
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

# A program whose implementation is that of a library, which has the same switches.
switches=("${small[@]:1}")
switches=("${switches[@]#-D}")
printf '%s\n' '#include <pktrt.h>' '#ifndef PKTRT_NO_RENDER' '#error "the switches of the library are not those of the program"' \
  '#endif' >"$root/user.c"
sed -n '3,$p' "$root/main.c" >>"$root/user.c"
cp "$root/user.c" "$root/user.cpp"

project_of() { # name, languages; its lines from standard input: a project for CMake, with all sources
  mkdir -p "$root/$1"
  cp "$root"/*.c "$root"/*.cpp "$root"/hit.h "$root/$1/"
  { printf 'cmake_minimum_required(VERSION 3.14)\nproject(a_project LANGUAGES %s)\n' "$2" && cat; } >"$root/$1/CMakeLists.txt"
}
configure() { # project, arguments of cmake
  local project="$root/$1"
  shift
  cmake -S "$project" -B "$project/build" -DCMAKE_C_COMPILER="$CC" -DCMAKE_CXX_COMPILER="$CXX" -DCMAKE_EXPORT_COMPILE_COMMANDS=ON \
    "$@" >"$project/said" 2>&1 || { grep -v '^$\|^-- ' "$project/said"; return 1; }
}
builds() { # project: what it builds by default
  cmake --build "$root/$1/build" >"$root/$1/said" 2>&1 || { tail -12 "$root/$1/said"; return 1; }
  ! grep -i -C3 warning "$root/$1/said"
}
small_cmake=(-DCMAKE_C_FLAGS="${small[*]}" -DCMAKE_CXX_FLAGS="${small[*]}") # for a program that compiles the implementation
small_static=(-DPKTRT_SWITCHES="$(IFS=';' && echo "${switches[*]}")")
by_cmake() { # project, program, arguments of cmake
  local project=$1 program=$2
  shift 2
  configure "$project" "$@" && builds "$project" && says "$version 2" "$root/$project/build/$program"
}
optimised() { # project, words: whether the last -O of each file with these words in its command is -O2, and there is such a file
  awk -v words="$2" '/"command":/ && index($0, words) { n++; print; sub(/.* -O/, ""); if ($1 != 2) bad = 1 } END { exit bad || !n }' \
    "$root/$1/build/compile_commands.json"
}
no_static_library() { says '' find "$root/$1/build" -name '*pktrt_static*.[ao]*'; } # project
mentions() { # words, command...: it fails, with these words
  local words=$1 out
  shift
  out=$("$@" 2>&1) && { echo "it succeeds"; return 1; }
  tr -s ' \n' ' ' <<<"$out" | grep -qF "$words" || { echo "$out"; return 1; }
}
versions_are_chosen() { # which of them find_package takes
  configure versions "-DCMAKE_PREFIX_PATH=$root/my tools" &&
    says "$taken" awk '$2 == "takes" { $1 = $2 = ""; print substr($0, 3) }' "$root/versions/said"
}
has_no_folder_in_it() { ! grep -rF "$root" "$root/my tools"; } # what is installed may be moved
if have cmake git "$CXX"; then
  # FetchContent, from a repository with what is here.
  repository="$root/repository"
  mkdir -p "$repository/examples"
  cp pktrt.h "$repository/"
  cp -R examples/cmake "$repository/examples/"
  commit=$(cd "$repository" && git init -q . && git add . && git -c user.name=x -c user.email=x@x -c commit.gpgsign=false commit -q -m x &&
    git rev-parse HEAD)
  text=$(awk '/^```cmake$/ {on = 1; next} /^```$/ {on = 0} on' examples/manual.md)
  lines=$(sed "s|<url>|\"file://$repository\"|; s|<commit>|$commit|" <<<"$text")
  attempt "the manual has three lines for CMake" [ "$(wc -l <<<"$text")" = 3 ]
  project_of "fetched in C" C <<CMAKE
$lines
add_executable(program main.c)
target_link_libraries(program PRIVATE pktrt::pktrt)
CMAKE
  attempt "FetchContent by the manual's lines: a C program that holds the implementation" \
    by_cmake "fetched in C" program "${small_cmake[@]}"
  attempt "a library that nobody links is not compiled" no_static_library "fetched in C"
  project_of "fetched in C++" CXX <<CMAKE
$lines
add_executable(program user.cpp)
target_link_libraries(program PRIVATE pktrt::static)
CMAKE
  attempt "FetchContent: a C++ program with the library, in a project without C" \
    by_cmake "fetched in C++" program "${small_static[@]}" -DCMAKE_BUILD_TYPE=Debug
  project_of "fetched badly" C <<CMAKE
${lines/SOURCE_SUBDIR examples\/cmake/}
add_executable(program main.c)
target_link_libraries(program PRIVATE pktrt::pktrt)
CMAKE
  attempt "control: without SOURCE_SUBDIR there is no such target" mentions "pktrt::pktrt" configure "fetched badly"

  # find_package, as the manual has it, of what has been installed and moved.
  attempt "what is installed names no folder" has_no_folder_in_it
  project_of found "C CXX" <<CMAKE
$(grep -o 'find_package(pktrt [0-9.]* REQUIRED)' examples/manual.md)
add_executable(program main.cpp)
target_link_libraries(program PRIVATE pktrt::pktrt)
add_executable(user user.c)
target_link_libraries(user PRIVATE pktrt::static)
CMAKE
  found=("-DCMAKE_PREFIX_PATH=$root/my tools" "${small_static[@]}")
  attempt "find_package: a C++ program that holds the implementation" by_cmake found program "${found[@]}" "${small_cmake[@]}"
  attempt "find_package: a C program with the library" by_cmake found user "${found[@]}" -DCMAKE_C_FLAGS= -DCMAKE_BUILD_TYPE=Debug
  attempt "the library of a Debug program is compiled with -O2" optimised found pktrt_static
  attempt "control: the program is not" fails optimised found user
  attempt "with -O0 if that is asked for" configure found -DPKTRT_COMPILE_OPTIONS=-O0
  attempt "so it is" fails optimised found pktrt_static
  attempt "control: it is not found elsewhere" mentions 'Could not find a package configuration file provided by "pktrt"' \
    configure found -Upktrt_DIR -DCMAKE_PREFIX_PATH="$root/nowhere"
  minor=$((version / 100 % 100)) patch=$((version % 100)) taken="0 0.$minor 0.$minor.$patch 0.18...0.999 0.$minor.$patch...1"
  refused="1 0.$((minor - 1)) 0.$((minor + 1)) 0.$minor.$((patch + 1)) 1.$minor 0.1...<0.$minor.$patch 0.$minor.$((patch + 1))...1"
  [ "$version" -ge 10000 ] && echo "install: from 1.0 on other versions are to be tried here" && failed=$((failed + 1))
  project_of versions NONE <<CMAKE
foreach(version $taken $refused)
  find_package(pktrt \${version} QUIET CONFIG)
  if(pktrt_FOUND)
    list(APPEND taken \${version})
    if(NOT pktrt_VERSION VERSION_EQUAL 0.$minor.$patch)
      message(FATAL_ERROR "it says version \${pktrt_VERSION}")
    endif()
  endif()
endforeach()
string(REPLACE ";" " " taken "\${taken}")
message(STATUS "takes \${taken}")
CMAKE
  attempt "find_package takes this minor version and no other, and ranges" versions_are_chosen
  project_of "found wrong" C <<<"find_package(pktrt 0.$((minor - 1)) REQUIRED)"
  attempt "another is refused by its number" mentions "version: 0.$minor.$patch" configure "found wrong" "${found[@]}"

  # add_subdirectory, of a copy in the project.
  project_of "with a copy" "C CXX" <<'CMAKE'
add_subdirectory(pktrt/examples/cmake)
add_executable(in_c main.c)
add_executable(in_cpp main.cpp)
target_link_libraries(in_c PRIVATE pktrt::pktrt)
target_link_libraries(in_cpp PRIVATE pktrt::pktrt)
CMAKE
  cp -R "$repository" "$root/with a copy/pktrt"
  attempt "add_subdirectory: a C program" by_cmake "with a copy" in_c "${small_cmake[@]}"
  attempt "and a C++ program" says "$version 2" "$root/with a copy/build/in_cpp"
  project_of "in a library" "C" <<'CMAKE'
add_subdirectory(pktrt/examples/cmake)
add_library(a SHARED a_user.c)
target_link_libraries(a PRIVATE pktrt::static)
add_executable(in_c in_c.c)
target_link_libraries(in_c PRIVATE a)
add_executable(without user.c)
target_include_directories(without PRIVATE pktrt)
target_compile_definitions(without PRIVATE PKTRT_NO_RENDER)
target_link_libraries(without PRIVATE m)
set_target_properties(without PROPERTIES EXCLUDE_FROM_ALL ON)
CMAKE
  cp -R "$repository" "$root/in a library/pktrt"
  printf '#define main a_main\n#include "user.c"\n' >"$root/in a library/a_user.c"
  printf 'int a_main(void);\nint main(void) { return a_main(); }\n' >"$root/in a library/in_c.c"
  attempt "a shared library with the static one in it" by_cmake "in a library" in_c "${small_static[@]}"
  attempt "it exports nothing of it" says 0 sh -c 'nm -D --defined-only "$1" | grep -c " pktrt"; :' sh "$root/in a library/build/liba.so"
  attempt "control: a program without it is not linked" mentions "undefined reference to" cmake --build "$root/in a library/build" -t without
fi

# --- Debug builds ---

# The implementation is optimised and the program is not; each file refuses to compile otherwise.
debug="$root/debug"
mkdir -p "$debug"
printf '%s\n' '#ifndef __OPTIMIZE__' '#error "the implementation is not optimised"' '#endif' '#define PKTRT_IMPLEMENTATION' \
  '#include "../../../../pktrt.h"' >"$debug/pktrt.c"
printf '%s\n' '#ifdef __OPTIMIZE__' '#error "the program is optimised"' '#endif' '#define PK_IMPLEMENTED' '#define PK_ENTRY_POINTS' \
  '#include "../../../../tests/checksum.c"' >"$debug/program.c"
printf '%s\n' 'program: program.o pktrt.o' "$(printf '\t')"'$(CC) $(CFLAGS) program.o pktrt.o -o $@ -lm' >"$debug/Makefile.without"
manual_line() { grep -oh "\`$1[^\`]*\`" examples/manual.md | tr -d '`'; } # how it begins
{ cat "$debug/Makefile.without" && manual_line 'pktrt\.o: '; } >"$debug/Makefile"
by_make() { make -C "$debug" CC="$CC" CFLAGS="-O0 -g" "$@"; }
timed() { # file, command...: its seconds of processor time
  local file=$1 TIMEFORMAT=%U
  shift
  { time "$@" 2>&1; } 2>"$file"
}
keeps_the_bits() { # program
  "$debug/$1" | sed '/^by /d' | diff tests/checksum.txt -
}
attempt "control: without the manual's line for make the implementation is not optimised" \
  mentions "the implementation is not optimised" by_make -f Makefile.without
attempt "by that line it is, in a program that is not" timed "$debug/seconds" by_make
attempt "this has the bits that are kept" keeps_the_bits program
if command -v cmake >/dev/null; then # what is skipped has been said
  for name in "debug by CMake" "debug without"; do
    project_of "$name" C <<CMAKE
add_executable(program program.c pktrt.c)
target_link_libraries(program PRIVATE m)
$([ "$name" = "debug without" ] || manual_line set_source_files_properties)
CMAKE
    sed 's,"../../../../pktrt.h",<pktrt.h>,' "$debug/pktrt.c" >"$root/$name/pktrt.c"
    { head -3 "$debug/program.c" && cat "$root/user.c"; } >"$root/$name/program.c"
  done
  flags=(-DCMAKE_BUILD_TYPE=Debug "-DCMAKE_C_FLAGS=${switches[*]/#/-D} -I../../../../..")
  attempt "by the manual's line for CMake it is, too" by_cmake "debug by CMake" program "${flags[@]}"
  attempt "control: without it is not" mentions "the implementation is not optimised" by_cmake "debug without" program "${flags[@]}"
fi

# Sanitizers, beside the time of -O2 -g and of the program, which are 1.3 times that of -O2.
read -ra sanitizers < <(manual_line '-O0 -g -fsanitize')
cat >"$debug/short.c" <<'C'
#include "../../../../pktrt.h"
#include <stdlib.h>
int main(void) { /* says that it has four vertices, and has three */
  static const uint32_t corners[] = {0, 1, 3};
  static pktrt_mesh_desc mesh;
  float *positions = (float *)calloc(9, sizeof *positions);
  mesh.positions = positions, mesh.vertex_count = 4, mesh.indices = corners, mesh.triangle_count = 1;
  pktrt_scene *scene = pktrt_scene_create(NULL);
  return !scene || !positions || pktrt_add_mesh(scene, &mesh, NULL);
}
C
sanitised() { "$CC" "${sanitizers[@]}" -DPKTRT_IMPLEMENTATION -x c -c pktrt.h -o "$debug/sanitised.o"; }
linked() { "$CC" "${sanitizers[@]}" "$debug/$1.c" "$debug/sanitised.o" -o "$debug/$1-sanitised" -lm; } # source
takes_twice_at_most() { # files with seconds
  awk '{ print; s[NR] = $1 } END { exit !(NR == 2 && s[1] > 0 && s[2] <= 2 * s[1] / 1.3) }' "$@"
}
attempt "with sanitizers, as the manual has it, it compiles" timed "$debug/seconds-sanitised" sanitised
attempt "in twice the time of -O2 at most" takes_twice_at_most "$debug/seconds" "$debug/seconds-sanitised"
attempt "a program is linked with it" linked program
attempt "this has the bits that are kept, and nothing is found" keeps_the_bits program-sanitised
attempt "so is one with a mistake" linked short
attempt "which is found" mentions "heap-buffer-overflow" "$debug/short-sanitised"

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
