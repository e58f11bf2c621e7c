#!/usr/bin/env bash
# The exercises of the course: solutions pass, skeletons fail, and both say so; the texts' pictures are there; listings that are not
# the code's are noticed.
# usage: course.sh FOLDER CHAPTERS..., as in build/course 01 02: the folder has NN_solution and NN_exercise, compiled with the checks.
set -u
built=$1 failed=0
shift
bad() {
  echo "$@"
  failed=1
}

for n; do
  chapter=${n#0}
  "$built/${n}_solution" >"$built/$n.txt" 2>&1 && [ "$(tail -1 "$built/$n.txt")" = "chapter $chapter: passed" ] ||
    { cat "$built/$n.txt"; bad "the solution of chapter $chapter does not pass"; }
  "$built/${n}_exercise" >"$built/$n.txt" 2>&1
  [ $? = 1 ] && tail -1 "$built/$n.txt" | grep -q "^chapter $chapter: failed: ." ||
    { cat "$built/$n.txt"; bad "the skeleton of chapter $chapter is not refused as it should be"; }
done

for picture in $(grep -ohE '\.pictures/course/[A-Za-z0-9_]+\.(png|svg)' examples/course/*.md | sort -u); do
  [ -s "$picture" ] || bad "a text shows $picture, which is not there (make course-pictures)"
done

# --- controls: texts that must not pass for filled in ---

listings=examples/course/listings.awk text=$built/wrong.md
printf '/* [part] */\nint x;\n/* [end] */\n' >"$built/wrong.c"
cp "$built/wrong.c" "$built/wrong_solution.c"
control() { # what is wrong, mark, code, what awk must say of it; or nothing: it must change the text
  printf '%s\n```c\n%s\n```\n' "$2" "$3" >"$text"
  if awk -f "$listings" "$text" >"$text.new" 2>"$text.said"; then
    [ -z "$4" ] && ! cmp -s "$text" "$text.new"
  else
    [ -n "$4" ] && grep -q "$4" "$text.said"
  fi || bad "not noticed: $1"
}
control 'other code' '<!-- listing wrong.c part -->' 'int y;' ''
control 'no such part' '<!-- listing wrong.c other -->' 'int x;' 'no part'
control 'no such file' '<!-- listing absent.c part -->' 'int x;' 'not there'
control 'a mark that is none' '<!-- listing wrong.c -->' 'int x;' 'not of the form'
control 'code of a solution' '<!-- listing wrong_solution.c part -->' 'int x;' 'a solution'
printf '<!-- listing wrong.c part -->\n```c\nint x;\n```\n' | tee "$text" >"$text.new"
awk -f "$listings" "$text" | cmp -s - "$text.new" || bad "what is right is changed"

# The same for figures: a text, and what awk must say of it; or nothing: it must change the text.
figures=examples/course/figures.awk
printf 'by kind: 1\n\n= share 0.25\n' >"$built/wrong.txt"
figure() { # what is wrong, the text, what awk must say
  printf '%s\n' "$2" >"$text"
  if awk -f "$figures" "$built/wrong.txt" "$text" >"$text.new" 2>"$text.said"; then
    [ -z "$3" ] && ! cmp -s "$text" "$text.new"
  else
    [ -n "$3" ] && grep -q "$3" "$text.said"
  fi || bad "not noticed: $1"
}
figure 'another value' 'It is 0.26<!-- share -->.' ''
figure 'a figure that nothing prints' 'It is 0.25<!-- part -->.' 'no program prints'
figure 'a decimal without a name' 'It is 0.25.' 'no figure'
figure 'another output' "$(printf '<!-- output by kind -->\n```\nby kind: 2\n```')" ''
figure 'no such output' "$(printf '<!-- output by size -->\n```\nby size: 2\n```')" 'prints nothing'
printf 'It is 0.25<!-- share -->, `0.5` and, by section 3.1, 0.75.\n<!-- given 0.75 -->\n' >"$text"
sed -i '1h;1d;$G' "$text" && awk -f "$figures" "$built/wrong.txt" "$text" | cmp -s - "$text" || bad "a right figure is changed"

[ $failed = 0 ] && echo "course: of $# chapters solutions pass and skeletons fail; of 10 wrong listings and figures each is noticed"
exit $failed
