#!/usr/bin/env bash
# Measures the pictures of `make demo`, and ray casting by one thread and two, for bench/README.md: pictures.sh BUILD RESULTS
# writes RESULTS/pictures.csv.
set -euo pipefail
cd "$(dirname "$0")/.."
build=$1 results=$2
work=$build/pictures
mkdir -p "$work"

# What render says of itself, as a row: size, threads, rays per sample, depth, Mrays/s, seconds.
said() { # scene, mode, samples, whether rays are counted
  awk -v scene="$1" -v mode="$2" -v samples="$3" -v counted="$4" '
    $1 == "picture" { width = $2; height = $4 + 0; threads = $NF }
    $1 == "seconds" { for (i = 1; i < NF; i++) if ($i == "render") seconds = $(i + 1) + 0 }
    $1 == "all" { mrays = $3 }
    $1 == "per" && $2 == "sample:" { rays = $3; depth = $7 }
    END {
      if (!seconds || (counted && !(mrays && rays))) exit 1
      printf "%s,%s,%d,%d,%d,%d,%d,%s,%s,%s,%s\n", scene, mode, width, height, samples, threads, counted, rays, depth, mrays, seconds
    }'
}
picture() { # scene, mode, samples, options...
  local scene=$1 mode=$2 samples=$3
  shift 3
  "$build/render" --no-progress --scene "$scene" --mode "$mode" --spp "$samples" "$@" -o "$work/picture.png" >"$work/said.txt"
  said "$scene" "$mode" "$samples" 1 <"$work/said.txt"
}
best_of_three() { # threads: the row of the quickest
  for _ in 1 2 3; do
    "$build/render" --no-progress --scene poolhall --spp 1 --no-count --threads "$1" >"$work/said.txt"
    said poolhall rcs 1 0 <"$work/said.txt"
  done | sort -t, -k11,11g | head -1
}

{
  "$build/provenance" make bench-pictures ${SIZE:+SIZE=$SIZE} ${SIZE_DRT:+SIZE_DRT=$SIZE_DRT}
  echo scene,mode,width,height,samples,threads,counted,rays_per_sample,depth,mrays,seconds
  for scene in poolhall conference rtrt; do
    picture $scene rcs 1 --size "${SIZE:-1024x1024}"
    picture $scene wrt 1 --size "${SIZE:-1024x1024}"
    picture $scene drt 64 --lights one --size "${SIZE_DRT:-512x512}"
  done
  best_of_three 1
  best_of_three 2
} >"$work/pictures.csv"
mv "$work/pictures.csv" "$results/pictures.csv"
