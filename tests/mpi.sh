#!/usr/bin/env bash
# Runs build/mpi with 4 and 7 ranks on this machine: pictures, frames and sums have the bits of build/render, whatever the ranks
# and their instruction sets; ranks that die; runs that are resumed. Each check has a control that must fail.
# usage: mpi.sh [directory of mpi and render], from the project's directory
set -u
. tests/check.sh
said="table.txt errors.txt" aloud=1
bin=$(realpath "${1:-build}")
dir=$(mktemp -d)
trap 'rm -rf "$dir"' EXIT
cd "$dir" || exit 1


# More ranks than cores are wanted; root, as containers have it, must say that it means it; and containers forbid processes to read
# each other's memory.
launch=(mpirun --oversubscribe)
[ "$(id -u)" != 0 ] || launch+=(--allow-run-as-root)
export OMPI_MCA_btl_vader_single_copy_mechanism=none
unset PKTRT_MPI_TEST

scene=()
one() { "$bin/render" --no-progress --no-count "${scene[@]}" "$@" >one.txt 2>errors.txt; } # one process
mpi() { # number of ranks, options...
  local n=$1
  shift
  timeout 100 "${launch[@]}" -n "$n" "$bin/mpi" --no-progress "${scene[@]}" "$@" >table.txt 2>errors.txt </dev/null
}
alone() { timeout 100 "$bin/mpi" --no-progress "${scene[@]}" "$@" >table.txt 2>errors.txt; } # one rank needs no mpirun
checksum() { grep '^pixels ' "$1"; }
equal() { cmp -s one.pfm "$1" && [ "$(checksum one.txt)" = "$(checksum table.txt)" ]; }
same() { mpi "$@" -o mpi.pfm && equal mpi.pfm && [ ! -e mpi.pfm-tiles ]; } # number of ranks, options...
says() { grep -q -- "$1" table.txt; }
count() { sed -n "s/.*[ ]\([0-9]*\) $1.*/\1/p" table.txt; } # words: the number before them in the table
units() { awk '$1 == "units" { print $2 }' table.txt; }
complains() { # word: one sentence of ours on standard error
  [ "$(grep -c '^error: ' errors.txt)" = 1 ] && grep -q -- "^error: .*$1" errors.txt
}

# --- pictures ---

scene=(--scene lamps-few --mode drt --spp 4 --size 96x80 --tile 16)
one -o one.pfm
for n in 4 7; do check "$n ranks make the picture of one process" same "$n"; done
check "one rank, two threads, too" same 1 --threads 2
check "the control: another seed makes another" fails same 4 --seed 1
sets=() several=()
for isa in scalar sse2 avx2 avx512; do
  if "$bin/render" --isa $isa --size 1x1 >/dev/null 2>&1; then sets+=("$isa"); else echo "          without $isa, which this CPU or this build lacks"; fi
done
mixed() { # options of the last rank...
  local isa
  several=()
  for isa in "${sets[@]}"; do several+=(-n 1 "$bin/mpi" --no-progress "${scene[@]}" -o mpi.pfm --isa "$isa" :); done
  timeout 100 "${launch[@]}" "${several[@]}" -n 1 "$bin/mpi" --no-progress "${scene[@]}" -o mpi.pfm "$@" >table.txt 2>errors.txt </dev/null
}
all_sets_worked() {
  local isa
  for isa in "${sets[@]}"; do awk -v isa="$isa" '$2 == isa && $3 > 0 { n++ } END { exit !n }' table.txt || return 1; done
}
same_by_mixed() { mixed && equal mpi.pfm && all_sets_worked; }
check "so do ranks with ${sets[*]} in one run, each of which makes tiles" same_by_mixed
check "a rank with other settings is refused" fails mixed --seed 1
check "by its number" complains "rank ${#sets[@]} has another"
check "an option that render alone has is refused in one line" fails mpi 4 --adaptive
check "by name" complains '--adaptive'
check "so is a mesh that is not there" fails "$bin/mpi" --mesh absent.tri 2>errors.txt
check "by name" complains 'absent.tri'

# --- passes ---

scene=(--scene sky --mode drt --spp 2 --size 64x48 --tile 16)
rule=(--target-error 0.05 --passes 60)
rules() { grep -E '^(error|used|  +RMSE)' "$1" | sed 's/;.*seconds.*//'; }
same_rules() { [ -n "$(rules table.txt)" ] && [ "$(rules table.txt)" = "$(rules one.txt)" ]; }
one "${rule[@]}" -o one.pfm
for n in 4 7; do
  check "$n ranks stop at the target where one process does" same "$n" "${rule[@]}"
  check "and say the same of the error" same_rules
done
check "which is a matter of the target, not of the passes" grep -q 'stopped: the target is reached' one.txt
check "the control: another target takes other passes" fails same 4 --target-error 0.1 --passes 60
check "and other errors" fails same_rules
rule=(--target-error 0.02 --passes 60)
one "${rule[@]}" --measure display -o one.pfm
check "errors as shown stop 4 ranks where they stop one process" same 4 "${rule[@]}" --measure display
check "and are said alike" same_rules
check "the control: the RMSE stops them elsewhere" fails same 4 "${rule[@]}"
kept() { # folder, number of ranks, word for a control
  PKTRT_MPI_TEST="keep $3" mpi "$2" --passes 6 --resume "$1"
}
same_sums() { kept "sums-$1" "$1" '' && diff -rq sums-1 "sums-$1"; }
kept sums-1 1 ''
for n in 4 7; do check "$n ranks add passes up in the order of one" same_sums "$n"; done
check "the control: added backwards" kept backwards 4 backwards
check "sums have other bits" fails diff -rq sums-1 backwards >differ.txt

# --- ranks that die, runs that are resumed ---

scene=(--scene lamps-few --mode drt --spp 4 --size 96x80 --tile 16)
one --seed 1 -o seed.pfm
one -o one.pfm
killed() { # rank, the first tile that it does not make, options...
  local rank=$1 n=$2
  shift 2
  PKTRT_MPI_TEST="die=$rank:$n" mpi 4 "$@"
}
whole() { [ ! -e mpi.pfm ] && [ "$(find mpi.pfm-tiles -name '*.tile' | wc -l)" -ge 3 ] && [ -z "$(find mpi.pfm-tiles -name '*.tmp')" ]; }
rm -f mpi.pfm
check "a run whose rank 2 is killed fails" fails killed 2 8 -o mpi.pfm
check "with one sentence, which tells the rank and what to do" complains 'rank 2 of 4 has died; run again with --resume mpi.pfm-tiles'
check "there are tiles, and no picture or half a file" whole
tiles=$(find mpi.pfm-tiles -name '*.tile' | wc -l)
cp -r mpi.pfm-tiles other && cp -r mpi.pfm-tiles spare
resumed() { # tiles taken up, damaged, of other settings: of a run that has made the others
  [ "$(count 'tiles taken up')" = "$1" ] && [ "$(count damaged)" = "$2" ] && [ "$(count 'of other settings')" = "$3" ] && [ "$(units)" = $((30 - $1)) ]
}
check "resumed, it has the same bits" same 4 --resume mpi.pfm-tiles
check "and takes these $tiles tiles up" resumed "$tiles" 0 0
check "the control: a run that is not resumed, whose ranks live" same 4
check "makes all tiles" [ "$(units)" = 30 ]
check "a run whose rank 0 is killed fails" fails killed 0 8 -o mpi.pfm
check "with one sentence, too" complains 'rank 0 has died; run again with --resume mpi.pfm-tiles'
check "and can be resumed" same 4 --resume mpi.pfm-tiles
damage() { # folder: one bit of a pixel in its first tile
  local file byte
  file=$(find "$1" -name '*.tile' | sort | head -1)
  byte=$(od -An -tu1 -j 1046 -N 1 "$file")
  printf '%b' "\\x$(printf %02x $((byte ^ 16)))" | dd of="$file" bs=1 seek=1046 conv=notrunc status=none
}
cp -r spare trusted
damage spare
damage trusted
check "where one bit of a tile is wrong" alone -o mpi.pfm --resume spare
check "that tile is made again" resumed $((tiles - 1)) 1 0
check "with the same bits" equal mpi.pfm
trusting() { PKTRT_MPI_TEST=trust alone "$@"; }
check "the control: without a look at its checksum" trusting -o mpi.pfm --resume trusted
check "it shows in the picture" fails equal mpi.pfm
# The first tile's word of the passes is the fifth; whoever writes another there can compute the hash, too.
forge() { # folder, passes
  python3 - "$(find "$1" -name '*.tile' | sort | head -1)" "$2" <<'PYTHON'
import array, sys
path, passes = sys.argv[1], int(sys.argv[2])
words = array.array("Q", open(path, "rb").read())
words[4], total = passes, 14695981039346656037
for word in words[:-1]:
    total = (total ^ word) * 1099511628211 % 2**64
words[-1] = total
open(path, "wb").write(words.tobytes())
PYTHON
}
for passes in 0 2 4294967297 18446744073709551615; do
  rm -rf forged && cp -r other forged && forge forged $passes
  check "where a tile says that it has had $passes passes of 1" alone -o mpi.pfm --resume forged
  check "that tile is made again" resumed $((tiles - 1)) 1 0
  check "with the same bits" equal mpi.pfm
done
rm -rf forged && cp -r other forged && forge forged 1
check "the control: one that is written anew and says 1" alone -o mpi.pfm --resume forged
check "is taken up" resumed "$tiles" 0 0
cp -r other trusted
cp -r other modes
check "tiles of another seed" alone -o mpi.pfm --resume other --seed 1
check "are not taken up" resumed 0 0 "$tiles"
check "and the picture is that of this one" cmp -s seed.pfm mpi.pfm
check "so it is with those of another mode" alone --resume modes --mode wrt
check "and another number of samples" resumed 0 0 "$tiles"
check "the control: where no one looks" trusting -o mpi.pfm --resume trusted --seed 1
check "they are in the picture" fails cmp -s seed.pfm mpi.pfm

# --- frames ---

scene=(--scene conference --mode rcs --size 64x48 --tile 16)
frames_equal() { # by which a rank has died, and a run has been resumed
  local k
  for k in 5 6 7; do
    one --frame $k -o one.pfm && cmp -s one.pfm "mpi-00$k.pfm" &&
      grep "^frame    $k: $(checksum one.txt | sed 's/pixels *//')" table.txt >/dev/null || return 1
  done
}
check "a run over three frames whose rank 1 is killed fails" fails killed 1 4 --frame 5-7 -o mpi.pfm
check "with one sentence" complains 'rank 1 of 4 has died'
check "7 ranks resume it" mpi 7 --frame 5-7 -o mpi.pfm --resume mpi.pfm-tiles
check "without making all tiles" [ "$(units)" -lt 36 ]
check "and each frame is that of one process" frames_equal
check "the control: frames differ" fails cmp -s mpi-005.pfm mpi-006.pfm
rm mpi-006.pfm && cp mpi-005.pfm mpi-006.pfm
check "which is noticed" fails frames_equal

echo "mpi: $((checks - failed)) passed, $failed failed"
[ $failed = 0 ]
