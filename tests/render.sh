#!/usr/bin/env bash
# What the command line does with meshes of extreme sizes, with its files when something goes wrong, with interrupts, and
# whether options and warnings get through.
# usage: render.sh [render], from the project's directory
set -u
. tests/check.sh
render=$(realpath "${1:-build/render}")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1

run() { "$render" --no-progress "$@" >table.txt 2>errors.txt; }
quiet() { run "$@" && [ ! -s errors.txt ]; }
ended() { # status, word, command...: that status, and one line on standard error with the word
  local status=$1 word=$2
  shift 2
  "$@"
  [ $? = "$status" ] && [ "$(wc -l <errors.txt)" = 1 ] && grep -q -- "^error: .*$word" errors.txt
}
refused() { ended 1 "$1" run "${@:2}"; } # word, arguments...

# --- meshes; values are floats in hexadecimal ---

words() { for x in "$@"; do printf '%b' "\\x${x:6:2}\\x${x:4:2}\\x${x:2:2}\\x${x:0:2}"; done; }
mesh() { # name, nine coordinates: one triangle
  local name=$1
  shift
  words 00000001 "$@" >"$name.tri"
}
corner() { # name, a, b: the triangle (a, a, a), (b, a, a), (a, b, a)
  mesh "$1" "$2" "$2" "$2" "$3" "$2" "$2" "$2" "$3" "$2"
}
zero=00000000 one=3f800000 far=4e6e6b28 beside=4e6e6b38 limit=71800000 minus=f1800000 within=717ffff0 tiny=0da24260
corner unit $zero $one
corner tiny $zero $tiny       # 1e-30
corner large $zero 6c800000   # 2^90
corner far $far $beside       # 1e9 and 16 floats more
corner next $far 4e6e6b29     # 1e9 and the next float
corner limit $limit $within   # 2^100 and 16 floats less
mesh flat-x $zero $zero $zero $zero $one $zero $zero $zero $one
mesh flat-y $zero $zero $zero $zero $zero $one $one $zero $zero
corner point $far $far
corner last $limit $limit
mesh line $zero $zero $zero $one $zero $zero 40000000 $zero $zero
mesh all $minus $minus $minus $limit $minus $minus $minus $limit $limit

hits() { awk '$1 == "primary" { print $NF }' table.txt; }
mean() { tail -c $((32 * 32 * 12)) picture.pfm | od -An -v -tf4 -w4 | awk '{ sum += $1 } END { print sum / NR }'; }
within() { awk -v a="$1" -v b="$2" -v part="$3" 'BEGIN { exit !(a > b * (1 - part) && a < b * (1 + part)) }'; }
framed_as_unit() { # two parts, name: as the same triangle of size 1, area and brightness to within these parts
  run --mesh "$3.tri" --size 32x32 -o picture.pfm && ! grep -v 'camera.fov_y is [0-2][.0-9]* degrees' errors.txt &&
    within "$(hits)" "$unit_hits" "$1" && within "$(mean)" "$unit_mean" "$2"
}
quiet --mesh unit.tri --size 32x32 -o picture.pfm
unit_hits=$(hits) unit_mean=$(mean)
check "a triangle of size 1 is seen" within "$unit_hits" 15 0.2
check "one of 1e-30 is framed and lit alike" framed_as_unit 0.01 0.05 tiny
check "one of 2^90, too" framed_as_unit 0.01 0.05 large
check "one at 1e9" framed_as_unit 0.5 0.1 far
check "one at 1e9 whose corners are neighbouring floats" framed_as_unit 0.7 0.3 next
check "one at 2^100, from the other side" framed_as_unit 0.5 0.3 limit
check "one that stands upright" quiet --mesh flat-x.tri --size 32x32
check "one that lies" quiet --mesh flat-y.tri --size 32x32
check "a point at 1e9 is refused by name" refused 'point.tri: there is nothing to see' --mesh point.tri --size 32x32
check "a point at 2^100" refused 'last.tri: there is nothing to see' --mesh last.tri --size 32x32
check "a line" refused 'line.tri: there is nothing to see' --mesh line.tri --size 32x32
check "one that fills the range of coordinates" refused 'all.tri: a camera' --mesh all.tri --size 32x32
check "which a camera within it makes no error" quiet --mesh all.tri --camera 0,0,1e30,0,0,-1e30 --size 32x32

# --- what pixels cost ---

costs() { tail -c $((32 * 32 * 4)) cost.pfm | od -An -v -tf4 -w4 | awk '{ sum += $1 } END { print sum }'; }
counted() { awk -v column="$1" '$1 == "all" { print $2 * $column }' table.txt; } # of the table: tests per ray
heat() { # what, the table's column, arguments...: the pixels' costs are all of what was counted
  quiet --mesh unit.tri --size 32x32 --spp 1 --heat "$1" -o cost.pfm "${@:3}" && within "$(costs)" "$(counted "$2")" 0.01
}
check "pixels share what boxes cost" heat boxes 5 --path single
alone=$(costs)
check "and triangles" heat triangles 6 --path single
check "and on the path of the paper" heat boxes 5 --path paper --packet 2
check "control: boxes are no triangles" fails heat boxes 6 --path single
check "the fast path counts no boxes" quiet --mesh unit.tri --size 32x32 --spp 1 --heat boxes -o cost.pfm
check "but its pixels cost what rays cost by themselves" within "$(costs)" "$alone" 0.01
check "colours are a picture" quiet --mesh unit.tri --size 128x64 --path paper --heat vectors -o heat.png
check "vectors are refused on other paths by name" refused '--heat: vectors' --mesh unit.tri --heat vectors

# --- files ---

start() { # an empty folder for the files, with one of before
  rm -rf files && mkdir files && echo before >files/old.png
}
there() { [ "$(ls -A files | tr '\n' ' ')" = "$*${*:+ }" ] || { ls -A files; return 1; }; } # names, sorted: these and no others
as_before() { there "$@" && echo before | cmp -s - files/old.png; }
all=(--buffers files/b --error-map files/error.png --passes 2)
good=(--mesh unit.tri --size 32x32)
start
check "all files are written" quiet "${good[@]}" -o files/old.png "${all[@]}"
check "and no other" there b-albedo.pfm b-depth.pfm b-normal.pfm error.png old.png
check "control: a file that is replaced is not as before" fails as_before b-albedo.pfm b-depth.pfm b-normal.pfm error.png old.png
start
check "a mesh that is not there is refused" refused 'absent.tri' --mesh absent.tri -o files/new.png "${all[@]}"
check "and leaves no file" as_before old.png
start
ln -s /dev/full files/b-normal.pfm
check "a buffer that cannot be written fails" refused 'No space' "${good[@]}" -o files/old.png "${all[@]}"
check "and leaves no file" as_before b-normal.pfm old.png
start
check "a folder that is not there is refused" refused 'No such' "${good[@]}" -o files/old.png --buffers /nowhere/at/all/x
check "a folder in place of a file" refused 'directory' "${good[@]}" -o files/old.png --buffers files/old.png/b
check "and leave no file" as_before old.png
ln -s real.png files/link.png
check "a link to a file that is not there yet is followed" quiet "${good[@]}" -o files/link.png
check "once more, when it is" quiet "${good[@]}" -o files/link.png
check "and stays a link" test -L files/link.png -a -f files/real.png -a ! -L files/real.png
chmod 604 files/old.png
check "a file is replaced" quiet "${good[@]}" -o files/old.png
check "and keeps its permissions" test "$(stat -c %a files/old.png)" = 604
(umask 027 && run "${good[@]}" -o files/new.png)
check "a new one has those of the umask" test "$(stat -c %a files/new.png)" = 640

# --- what is no regular file ---

check "a device is written directly" quiet "${good[@]}" -o /dev/null
check "a full one" refused 'No space' "${good[@]}" -o /dev/full
check "and stays a device" test -c /dev/null -a -c /dev/full
run "${good[@]}" -o files/new.png
"$render" "${good[@]}" -o /dev/stdout >out.txt 2>errors.txt
check "standard output begins with the picture" cmp -n "$(wc -c <files/new.png)" files/new.png out.txt
check "and ends with the table" grep -aq 'rays by depth' out.txt
mkfifo files/pipe.png
timeout 20 cat files/pipe.png >out.png &
check "a pipe is written" timeout 20 "$render" "${good[@]}" -o files/pipe.png >table.txt 2>errors.txt
wait
check "with the picture" cmp files/new.png out.png

# --- interrupts ---

# timeout --foreground sends the signal once, to the program alone
interrupted() { # signal, arguments...: after half a second
  timeout --preserve-status --foreground -k 20 -s "$1" 0.5 "$render" --no-progress "${@:2}" >table.txt 2>errors.txt
}
long=("${good[@]}" --time 20 --tile 8 -o files/old.png --buffers files/b --error-map files/error.pfm)
start
check "Ctrl-C cancels a picture" ended 130 interrupted interrupted INT "${long[@]}"
check "SIGTERM, too" ended 143 interrupted interrupted TERM "${long[@]}"
check "SIGHUP, too" ended 129 interrupted interrupted HUP "${long[@]}"
check "and leave no file" as_before old.png
start
mkfifo files/b-albedo.pfm # has no reader, so that the program waits while temporary files are there
"$render" --no-progress "${good[@]}" -o files/old.png --buffers files/b >table.txt 2>errors.txt &
for _ in {1..200}; do
  there b-albedo.pfm old.png >seen.txt || break
  sleep 0.05
done
kill -TERM $!
check "so it is while files are written" ended 143 interrupted wait $!
check "control: there were some" grep -q tmp seen.txt
check "which leaves none either" as_before b-albedo.pfm old.png

# --- options and warnings ---

sum() { awk '/checksum/ { print $NF }' table.txt; }
shadow_tests() { awk '$1 == "shadow" { print $4 }' table.txt; } # for each ray
tells() { # the pattern of every line on standard error
  [ -s errors.txt ] && fails grep -v -- "$1" errors.txt >/dev/null
}
differs() { [ -n "$1" ] && [ "$1" != "$2" ]; }
small=(--scene poolhall --size 48x48 --path paper)
check "a picture is made in RCS" run "${small[@]}"
plain=$(sum) tests=$(shadow_tests)
check "with warnings that it shows no mirrors, each a line" tells '^warning: .'
check "shadow packets of all lights" run "${small[@]}" --shadows together
check "change no pixel" test "$(sum)" = "$plain"
check "but are traced otherwise" differs "$(shadow_tests)" "$tests"
check "normals of triangles" run "${small[@]}" --normals geometric
check "change the picture" differs "$(sum)" "$plain"
check "smooth ones and packets for each light" run "${small[@]}" --normals smooth --shadows per-light
check "are what it had" test "$(sum)" = "$plain" -a "$(shadow_tests)" = "$tests"
check "a picture is made in DRT, without a warning" quiet "${small[@]}" --mode drt --spp 2
plain=$(sum)
check "the naive mapping" quiet "${small[@]}" --mode drt --spp 2 --phong naive
check "changes the picture" differs "$(sum)" "$plain"
check "the careful one" quiet "${small[@]}" --mode drt --spp 2 --phong careful
check "is what it had" test "$(sum)" = "$plain"

# A picture of all directions: two texels of 1, and two that are dark; then one that is cut off.
sky() { printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n'; }
{ sky; printf '\200\200\200\201\200\200\200\201'; } >day.hdr
{ sky; printf '\200\200\200\175\200\200\200\175'; } >night.hdr
{ sky; printf '\200\200\200'; } >torn.hdr
lit=(--mesh unit.tri --size 32x32 --mode drt --spp 4)
check "a picture of all directions lights a mesh" quiet "${lit[@]}" --environment day.hdr -o picture.pfm
day=$(mean)
check "and a dark one" quiet "${lit[@]}" --environment night.hdr -o picture.pfm
check "as much less as it is darker" within "$(mean)" "$(awk -v day="$day" 'BEGIN { print day / 16 }')" 0.001
check "one that is cut off is refused" refused 'torn.hdr: corrupt' "${lit[@]}" --environment torn.hdr
check "one that is not there, too" refused 'absent.hdr: cannot be read' "${lit[@]}" --environment absent.hdr

check "other words are refused: normals" refused 'none of: smooth, geometric' --normals bumpy
check "shadows" refused 'none of: per-light, together' --shadows apart
check "phong" refused 'none of: careful, naive' --phong clever
check "adaptive passes of too few samples are refused" refused '8 samples at least' --adaptive --spp 7
check "of 8 they are made in four" quiet --mesh unit.tri --size 32x32 --adaptive --spp 8
check "of two samples each" grep -q '2 per pixel and pass' table.txt

[ $failed = 0 ] && echo "render: $checks checks passed" && exit
echo "render: $failed of $checks checks failed"
exit 1
