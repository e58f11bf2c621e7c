#!/usr/bin/env bash
# The table of the paper's concepts in the README of the course: each concept has a row; the section that is said to explain it is there
# and has its words; the picture is shown by a chapter; what is said to play with it is there. Then copies that are wrong, each of
# which must be noticed.
# usage: concepts.sh, in the folder of the project
set -u
course=examples/course

# A concept, as its row begins, and words that the section which explains it must have.
concepts='first active ray|first active
intervals|interval
frustum of rays with a common origin|plane
frustum of rays without a common origin|hull
assembly by type|ray type
assembly by run|run
assembly by group|group
assembly by octant|octant
blind assembly|blind
figure 3|sixteen squares
motion of triangles|key
interleaved sampling|interleaved
Phong mapping|lobe
stochastic choice|chosen at random
refit|refit
table 1|table 1
table 2|table 2
table 3|table 3
SIMD and amortisation|amortisation
ray tree attenuation|attenuation
figure 6|figure 6
figure 7|figure 7
figure 8|figure 8'

# Prints what is wrong with the table of the README $1; nothing, if nothing is.
wrong_rows() {
  local readme=$1 name words row explained shown played text anchor picture target
  while IFS='|' read -r name words; do
    row=$(grep -F "| $name |" "$readme")
    [ "$(printf '%s' "$row" | grep -c .)" = 1 ] || { echo "$name: not in one row of the table"; continue; }
    IFS='|' read -r _ _ explained shown played _ <<<"$row"
    text=$(sed -n 's/.*](\([^)#]*\)#.*/\1/p' <<<"$explained")
    anchor=$(sed -n 's/.*#\([^)]*\)).*/\1/p' <<<"$explained")
    [ -f "$course/$text" ] || { echo "$name: the text $text is not there"; continue; }
    section_of "$course/$text" "$anchor" | tr '\n' ' ' | grep -qi -- "$words" || echo "$name: $text#$anchor is not there, or does not say \"$words\""
    picture=$(sed -n 's/.*](\([^)]*\)).*/\1/p' <<<"$shown")
    case $picture in
      *.md#*) section_of "$course/${picture%#*}" "${picture#*#}" | grep -q '^|' || echo "$name: $picture has no table" ;;
      *) [ -s "$course/$picture" ] && grep -qF -- "]($picture)" "$course"/[0-9]*.md || echo "$name: no chapter shows $picture" ;;
    esac
    target=$(sed -n 's/.*](\([^) ]*\)[^)]*).*/\1/p' <<<"$played")
    case $target in
      http://localhost:8000/*) grep -qF -- "($target " "$course"/[0-9]*.md || echo "$name: no chapter links to $target" ;;
      [0-9][0-9]_exercise.c) [ -f "$course/$target" ] && [ -f "$course/${target%%_*}_check.c" ] || echo "$name: $target has no check" ;;
      *) [ -n "$target" ] && [ -f "$course/$target" ] || echo "$name: nothing to play with at \"$target\"" ;;
    esac
  done <<<"$concepts"
}

# Prints the section of the text $1 whose heading has the anchor $2.
section_of() {
  awk -v anchor="$2" '
    /^## / {
      slug = tolower(substr($0, 4))
      gsub(/[^a-z0-9 _-]/, "", slug)
      gsub(/ /, "-", slug)
      inside = slug == anchor
    }
    inside' "$1"
}

said=$(wrong_rows "$course/README.md")
[ -z "$said" ] || { echo "$said"; echo "concepts: the table of $course/README.md is not as it should be"; exit 1; }

# --- controls ---
copy=$(mktemp) failed=0
trap 'rm -f "$copy"' EXIT
control() { # what is wrong, a sed command, what must be said
  sed "$2" "$course/README.md" >"$copy"
  wrong_rows "$copy" | grep -q -- "$3" || { echo "not noticed: $1"; failed=1; }
}
control 'a row is missing' '/^| first active ray |/d' '^first active ray: not in one row'
control 'a row stands twice' '/^| refit |/p' '^refit: not in one row'
control 'a section that is not there' '/^| figure 3 |/s/#[a-z-]*)/#another)/' '^figure 3: .* is not there, or'
control 'a section that does not say it' '/^| refit |/s/(14_motion.md#[a-z-]*)/(14_motion.md#the-triangle-test)/' '^refit: .* does not say'
control 'a picture that is not there' '/^| figure 6 |/s/06_figure6/06_other/' '^figure 6: no chapter shows'
control 'a section without a table' '/^| table 2 |/s/\[table\]([^)]*)/[table](15_table.md#exercise)/' '^table 2: .* has no table'
control 'a link that no chapter has' '/^| first active ray |/s/event=142/event=143/' '^first active ray: no chapter links'
control 'an exercise without a check' '/^| refit |/s/14_exercise/88_exercise/' '^refit: 88_exercise.c has no check'

[ $failed = 0 ] && echo "concepts: $(grep -c . <<<"$concepts") concepts of the paper have their places; 8 wrong tables are noticed"
exit $failed
