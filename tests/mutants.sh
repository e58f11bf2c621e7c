#!/usr/bin/env bash
# Plants single faults in a copy of pktrt.h, one at a time, in every room (a section with a >>tag), and tells which of them the tests
# of `make test` notice. From the project's directory: tests/mutants.sh; the Makefile has it as `make mutants`.
#   COUNT=400    faults, shared out to the rooms by the number of lines that could have one, LEAST=3 in each room
#   SEED=1       which ones; tests/mutants/faults.awk has the rules
#   JOBS         how many at a time, HOURS=3 at most; what is known is kept in build/mutants/results.csv: the next run goes on from there
#   ROOMS="..."  these rooms only
#   PLANTED=FILE the faults of a list in place of those that are drawn: `in ROOM`, then `-` a piece of one line as it is and `+` that
#                piece with the fault; tests/mutants/planted.txt has some that people thought of
# tests/mutants.sh --score only prints what is known, --list what would be planted.
#
# The library is compiled for one instruction set (AVX2, SSE2 where there is no AVX2, else scalar); all other objects are those of the
# header as it is. Tests run in the order of how many faults they noticed in how little time, small runs (test --small) before full
# ones, of those that take no more than five seconds, and end with the first failure; tests/checksum.c comes between them (of a list,
# behind them: tests should say what is wrong), tests/render.sh last. A fault that does not compile, or leaves the machine code as it is, makes room for the next
# one. A crash and an endless loop are noticed. Survivors count as equivalent where tests/mutants/equivalent.txt has an argument.
# Fails below $REQUIRED (95) percent.
set -u
cd "$(dirname "$0")/.." || exit 1
here=$PWD
dir=build/mutants
CC=${CC:-gcc} JOBS=${JOBS:-$(nproc 2>/dev/null || echo 1)} SEED=${SEED:-1} COUNT=${COUNT:-400} LEAST=${LEAST:-3} HOURS=${HOURS:-3}
REQUIRED=${REQUIRED:-95} ROOMS=${ROOMS:-} PLANTED=${PLANTED:-}
export CC JOBS SEED COUNT LEAST HOURS REQUIRED ROOMS PLANTED

leave_out="-DPKTRT_NO_SCALAR -DPKTRT_NO_SSE2 -DPKTRT_NO_AVX512" set=AVX2
if ! grep -qw avx2 /proc/cpuinfo 2>/dev/null; then
  leave_out="-DPKTRT_NO_SCALAR -DPKTRT_NO_AVX2 -DPKTRT_NO_AVX512" set=SSE2
  case $(uname -m) in x86_64 | i?86) ;; *) leave_out="-DPKTRT_NO_SIMD" set=scalar ;; esac
fi
flags="-std=c99 -ffp-contract=off $leave_out"
# A batch of tests that takes longer than so many seconds is counted as if it hung.
slowest() { awk -v sum="$1" 'BEGIN { print int(20 + 8 * sum) }'; }

# --- one fault: what becomes of it goes to results.csv as key,tests,room,rule,line,outcome,seconds,"who noticed it" ---

# It asks what all others of its kind have counted, in the same run, and so has one of its own, the last.
together="stable: every zero stands beside a control that is not zero" kind=stable

# Batches of tests, each twice as long as the one before: lines of seconds, small or full, sentence, in the order of the binary.
plan() {
  awk -F "\t" -v together="$together" -v kind="$kind" '
    FILENAME ~ /results/ { # so far
      n = split($0, field, ",")
      by = $0
      sub(/^[^"]*"/, "", by); sub(/"$/, "", by); sub(/^(crash|time): /, "", by)
      if (n > 6 && field[6] == "noticed") kills[by]++
      next
    }
    $3 == together || ($1 == "full" && $2 > 5) { next }
    { # the tests as they run without a fault: small or full, seconds, sentence
      count++
      order[count] = count; mode[count] = $1; seconds[count] = $2 + 0.005; name[count] = $3
      worth[count] = (kills[$1 " " $3] + ($1 == "small" ? 0.1 : 0.02)) / seconds[count]
      if (substr($3, 1, length(kind)) == kind) of_kind[$1] += $2
    }
    END {
      for (gap = int(count / 2); gap > 0; gap = int(gap / 2))
        for (i = gap + 1; i <= count; i++) {
          x = order[i]
          for (j = i; j > gap && worth[order[j - gap]] < worth[x]; j -= gap) order[j] = order[j - gap]
          order[j] = x
        }
      size = 0.25; sum = 0; batch = 1
      for (i = 1; i <= count; i++) {
        if (sum && sum + seconds[order[i]] > size) { batch++; sum = 0; size *= 2 }
        sum += seconds[order[i]]
        printf "%d\t%s\t%06d\t%s\t%s\n", batch, mode[order[i]] == "small" ? "a" : "b", order[i], seconds[order[i]], name[order[i]]
      }
      for (run in of_kind) if (run == "small") printf "%d\t%s\t%06d\t%s\t%s\n", ++batch, run == "small" ? "a" : "b", 0, of_kind[run], kind
    }' "$dir/results.csv" "$dir/tests.tsv" | sort -t "$(printf "\t")" -k 1,1n -k 2,3
}

one() { # the fault's line in todo.tsv: key, room, rule, line, new text
  local key room rule line new work outcome="" by="" start=$SECONDS
  [ "$(date +%s)" -lt "$DEADLINE" ] || return 0
  IFS=$'\t' read -r key room rule line new < <(sed -n "$1p" "$dir/todo.tsv")
  work=$dir/work/$key
  prepare "$work"
  LINE=$line NEW=$new awk 'NR == ENVIRON["LINE"] { print ENVIRON["NEW"]; next } { print }' pktrt.h >"$work/pktrt.h"
  if ! (cd "$work" && $CC $flags -O1 -w -c tests/tree.c -o tree.o) >"$work/said" 2>&1; then
    outcome=refused
  elif [ "$line" != 0 ] && cmp -s "$work/tree.o" "$dir/intact/tree.o"; then
    outcome=same
  elif ! $CC "$dir"/objects/*.o "$work/tree.o" -o "$work/test" -lm -lpthread >"$work/said" 2>&1; then
    outcome=refused
  else
    ask "$work"
  fi
  printf '%s,%s,%s,%s,%s,%s,%s,"%s"\n' "$key" "$TESTS" "$room" "$rule" "$line" "$outcome" $((SECONDS - start)) "$by" >>"$dir/results.csv"
  printf '%-9s %4d s  %s, %s, line %s  %s\n' "$outcome" $((SECONDS - start)) "$room" "$rule" "$line" "$by"
  rm -rf "$work"
}

prepare() { # a folder that includes its own pktrt.h
  mkdir -p "$1/tests" "$1/examples"
  ln -sf "$here"/tests/*.[ch] "$1/tests/"
  ln -sf "$here"/examples/*.[ch] "$1/examples/"
}

# Tells whether pictures have other sums than the header has.
other_sums() { # the fault's folder
  (cd "$1" && $CC $flags -O1 -w tests/checksum.c -o checksum -lm) >"$1/said" 2>&1
  ! timeout -k 5 60 "$1/checksum" 2>&1 | sed '/^by /d' | cmp -s - tests/checksum.txt
}

# Sets outcome and by.
ask() { # the fault's folder
  local batch mode seconds status sentences summed=${PLANTED:+last}
  plan >"$1/plan"
  while read -r batch mode; do
    if [ "$mode" = b ] && [ -z "$summed" ]; then
      summed=yes
      if other_sums "$1"; then
        outcome=noticed by="tests/checksum.txt"
        return
      fi
    fi
    mapfile -t sentences < <(awk -F '\t' -v b="$batch" -v m="$mode" '$1 == b && $2 == m { print $5 }' "$1/plan")
    seconds=$(awk -F '\t' -v b="$batch" -v m="$mode" '$1 == b && $2 == m { sum += $4 } END { print sum }' "$1/plan")
    (ulimit -v 12000000 -c 0; cd "$here" && exec timeout -k 5 "$(slowest "$seconds")" \
      "$1/test" --first $([ "$mode" = a ] && echo --small) "${sentences[@]}") >"$1/said" 2>&1
    status=$?
    [ $status = 0 ] && continue
    outcome=noticed
    by=$(grep -a '^FAILED' "$1/said" | head -1 | sed 's/^FAILED *[0-9.]* s  //')
    # Who crashed or hung is the one behind the last that passed.
    [ -n "$by" ] || by=$(awk -v m="$mode" '
      FNR == NR { if (sub(/^passed *[0-9.]* s  /, "")) last = $0; next }
      !name { split($0, part, "\t"); if (!last || seen) name = part[5]; if (part[5] == last) seen = 1 }
      END { print name }' "$1/said" <(awk -F '\t' -v b="$batch" -v m="$mode" '$1 == b && $2 == m' "$1/plan"))
    by="$([ "$mode" = a ] && echo small || echo full) $by"
    grep -aq '^FAILED' "$1/said" || by="$([ $status = 124 ] && echo time || echo crash): $by"
    return
  done < <(cut -f 1,2 "$1/plan" | uniq)
  outcome=survived
  if [ "$summed" = last ] && other_sums "$1"; then
    outcome=noticed by="tests/checksum.txt"
    return
  fi
  [ -e "$dir/intact/render" ] || return
  if ! (cd "$1" && $CC $flags -O1 -w examples/render.c -o render -lm -lpthread) >"$1/said" 2>&1; then outcome=refused
  elif ! timeout -k 5 120 tests/render.sh "$1/render" >"$1/said" 2>&1; then outcome=noticed by="tests/render.sh"; fi
}

if [ "${1:-}" = --one ]; then
  one "$2"
  exit
fi

# --- what all faults share ---

# shellcheck disable=SC2086
compiled_lines() { # of pktrt.h, for this instruction set
  $CC $flags -DPKTRT_IMPLEMENTATION -E -x c pktrt.h | awk '
    /^# [0-9]+ "/ { mine = $3 == "\"pktrt.h\""; line = $2 - 1; next }
    { line++ }
    mine && /[^ ]/ { print line }' | sort -nu
}

header=$({ cat pktrt.h tests/mutants/faults.awk; echo "$flags"; $CC --version; } | cksum | tr -d ' ')
TESTS=$(cat tests/*.[ch] tests/fuzz/*.[ch] tests/render.sh tests/checksum.txt examples/*.[ch] | cksum | tr -d ' ')
DEADLINE=$(($(date +%s) + $(awk -v h="$HOURS" 'BEGIN { print int(3600 * h) }')))
export TESTS DEADLINE
mkdir -p "$dir/objects" "$dir/intact"
touch "$dir/results.csv"

# The same columns as of drawn faults, of a list. A piece that stands in no line of its room, or in several, is told and left out.
list_planted_faults() {
  awk -v OFS='\t' -v rooms=" $ROOMS " '
    function hash(text, start,    h, i) {
      h = start
      for (i = 1; i <= length(text); i++) h = (h * 131 + code_of[substr(text, i, 1)]) % 2147483647
      return sprintf("%08x", h)
    }
    BEGIN { for (i = 32; i < 127; i++) code_of[sprintf("%c", i)] = i }
    FILENAME == "pktrt.h" {
      if (match($0, /^ *\/\* >>[a-z]+/)) { room = substr($0, RSTART, RLENGTH); sub(/.*>>/, "", room) }
      line[FNR] = $0; in_room[FNR] = room; lines = FNR
      next
    }
    /^in / { only = substr($0, 4); next }
    /^- / { old = substr($0, 3); next }
    /^\+ ?/ {
      if (rooms !~ /^ *$/ && !index(rooms, " " only " ")) next
      new = substr($0, 3); found = 0
      for (i = 1; i <= lines; i++) if (in_room[i] == only && index(line[i], old)) { found++; at = i }
      if (found != 1) { printf "%d lines of %s have: %s\n", found, only, old >"/dev/stderr"; next }
      start = index(line[at], old)
      text = substr(line[at], 1, start - 1) new substr(line[at], start + length(old))
      count[only]++; n++
      fault[n] = hash(line[at] text, 1) hash(line[at] text, 7) OFS only OFS "planted" OFS at OFS line[at] OFS text
      of[n] = only
    }
    END { for (i = 1; i <= n; i++) print fault[i], count[of[i]] }' pktrt.h "$PLANTED" >"$dir/faults.tsv"
}

# key, room, rule, line, old, new, how many of the room are wanted; in the order of the room
list_faults() {
  [ -z "$PLANTED" ] || { list_planted_faults; return; }
  compiled_lines >"$dir/lines"
  awk -v seed="$SEED" -f tests/mutants/faults.awk "$dir/lines" pktrt.h >"$dir/all.tsv"
  awk -F '\t' -v OFS='\t' -v header="$header" -v count="$COUNT" -v least="$LEAST" -v rooms=" $ROOMS " '
    function hash(text, start,    h, i) {
      h = start
      for (i = 1; i <= length(text); i++) h = (h * 131 + code_of[substr(text, i, 1)]) % 2147483647
      return sprintf("%08x", h)
    }
    BEGIN { for (i = 32; i < 127; i++) code_of[sprintf("%c", i)] = i }
    rooms !~ /^ *$/ && !index(rooms, " " $1 " ") { next }
    FNR == NR { if (!($1 in lines)) { lines[$1] = $3; total += $3 } next }
    {
      wanted = int(count * lines[$1] / total + 0.5)
      print hash(header $5 $7, 1) hash(header $5 $7, 7), $1, $4, $5, $6, $7, wanted < least ? least : wanted
    }' "$dir/all.tsv" "$dir/all.tsv" >"$dir/faults.tsv"
}

build_the_rest() {
  local file
  [ "$(cat "$dir/built" 2>/dev/null)" = "$header $TESTS" ] && return
  echo "building the tests for $set alone"
  rm -rf "$dir/objects" "$dir/intact"
  mkdir -p "$dir/objects"
  prepare "$dir/intact"
  cp pktrt.h "$dir/intact/"
  {
    for file in tests/main.c $(grep -L "^int main(" tests/*.c tests/fuzz/*.c); do # others are programs of their own
      case $file in tests/tree.c | tests/fuzz/main.c) continue ;; esac
      echo "$CC $flags -O2 -w -c $file -o $dir/objects/$(echo "${file%.c}" | tr / _).o"
    done
    echo "cd $dir/intact && $CC $flags -O1 -w -c tests/tree.c -o tree.o"
    echo "cd $dir/intact && $CC $flags -O1 -w examples/render.c -o render -lm -lpthread"
  } | xargs -P "$JOBS" -d '\n' -n 1 sh -c
  $CC "$dir"/objects/*.o "$dir/intact/tree.o" -o "$dir/intact/test" -lm -lpthread || exit 1
  # The header as it is must pass, all at the same time, as faults are looked for.
  printf '%s\n' "$dir/intact/test --small >$dir/small.txt" "$dir/intact/test >$dir/full.txt" \
    "tests/render.sh $dir/intact/render >$dir/render.txt || rm -f $dir/intact/render" | xargs -P "$JOBS" -d '\n' -n 1 sh -c
  if grep -h -A 7 -B 7 '^FAILED' "$dir/small.txt" "$dir/full.txt" || ! grep -q ' 0 failed' "$dir/small.txt" || ! grep -q ' 0 failed' "$dir/full.txt"; then
    echo "mutants: the tests fail for the header as it is"
    exit 1
  fi
  [ -e "$dir/intact/render" ] || echo "mutants: tests/render.sh is left out, it fails here for the header as it is"
  for file in small full; do sed -n "s/^passed *\([0-9.]*\) s  /$file\t\1\t/p" "$dir/$file.txt"; done >"$dir/tests.tsv"
  awk -F '\t' '{ sum[$1] += $2 } END { printf "without a fault, the small run takes %d s, the full one %d s\n", sum["small"], sum["full"] }' "$dir/tests.tsv"
  echo "$header $TESTS" >"$dir/built"
}

# Of each room as many as are wanted, less those that are noticed or survived all of today's tests.
choose() {
  awk -F '\t' -v OFS='\t' -v tests="$TESTS" '
    FILENAME ~ /results/ {
      split($0, field, ",")
      if (field[6] != "survived" || field[2] == tests) outcome[field[1]] = field[6]
      next
    }
    {
      if ($1 in outcome) { if (outcome[$1] !~ /refused|same/) counted[$2]++ }
      else { pending[$2, ++n[$2]] = $1 OFS $2 OFS $3 OFS $4 OFS $6; if (n[$2] == 1) order[++rooms] = $2 }
      wanted[$2] = $7
      if (++rank[$2] > most) most = rank[$2]
    }
    END {
      for (turn = 1; turn <= most; turn++)
        for (r = 1; r <= rooms; r++)
          if (counted[order[r]] + turn <= wanted[order[r]] && turn <= n[order[r]]) print pending[order[r], turn]
    }' "$dir/results.csv" "$dir/faults.tsv"
}

# --- the score ---

score() {
  awk -F '\t' -v required="$REQUIRED" -v tests="$TESTS" '
    function trimmed(text) { sub(/^ +/, "", text); sub(/ +$/, "", text); return text }
    function argument(room, old, new,    i, at) { # of the first entry whose change this is
      for (i = 1; i <= pairs; i++) {
        if (where[i] != "" && where[i] != room) continue
        at = index(old, minus[i])
        while (at) {
          if (substr(old, 1, at - 1) plus[i] substr(old, at + length(minus[i])) == new) return why[entry[i]]
          if (!index(substr(old, at + 1), minus[i])) break
          at += index(substr(old, at + 1), minus[i])
        }
      }
      return ""
    }
    FILENAME ~ /equivalent/ {
      if (text && /^(in|-) /) { entries++; text = 0; only = "" }
      if (/^in /) only = substr($0, 4)
      else if (/^- /) { minus[++pairs] = substr($0, 3); entry[pairs] = entries + 0; where[pairs] = only "" }
      else if (/^\+/) plus[pairs] = substr($0, 3)
      else if (!/^#/ && !/^ *$/) { why[entries + 0] = why[entries + 0] (text ? " " : "") $0; text = 1 }
      next
    }
    FILENAME ~ /results/ {
      split($0, field, ",")
      if (field[6] != "survived" || field[2] == tests) outcome[field[1]] = field[6]
      next
    }
    {
      if (!($2 in wanted)) order[++rooms] = $2
      wanted[$2] = $7
      what = outcome[$1]
      if (what == "" || planted[$2] == $7) next
      if (what == "refused") { refused++; next }
      if (what == "same") { same++; next }
      planted[$2]++
      if (what == "noticed") { noticed[$2]++; next }
      reason = argument($2, $5, $6)
      text = sprintf("%s, %s, line %d\n  - %s\n  + %s\n", $2, $3, $4, trimmed($5), $6 ~ /[^ ]/ ? trimmed($6) : "")
      if (reason != "") { equivalent[$2]++; proofs = proofs text "  " reason "\n" }
      else { survived[$2]++; survivors = survivors text }
    }
    END {
      printf "%-12s %8s %8s %11s %9s %6s\n", "room", "planted", "noticed", "equivalent", "survived", "score"
      for (r = 1; r <= rooms; r++) {
        room = order[r]
        # WHY + 0: some versions of gawk crash over elements that are handed on without a value
        print_row(room, planted[room] + 0, noticed[room] + 0, equivalent[room] + 0, survived[room] + 0)
        all += planted[room]; all_noticed += noticed[room]; all_equivalent += equivalent[room]; all_survived += survived[room]
        missing += wanted[room] - planted[room]
      }
      print_row("all", all, all_noticed, all_equivalent, all_survived)
      printf "%d more did not compile, %d left the machine code as it was\n", refused, same
      if (missing) printf "%d are not planted yet, or have no more lines to be planted in\n", missing
      if (proofs) printf "\nEquivalent, with the argument:\n%s", proofs
      if (survivors) printf "\nSurvivors:\n%s", survivors
      exit !(all > all_equivalent && 100 * all_noticed >= required * (all - all_equivalent))
    }
    function print_row(room, planted, noticed, equivalent, survived) {
      printf "%-12s %8d %8d %11d %9d %6s\n", room, planted, noticed, equivalent, survived, \
        (planted > equivalent ? sprintf("%.1f%%", 100 * noticed / (planted - equivalent)) : "-")
    }' "$dir/results.csv" tests/mutants/equivalent.txt "$dir/faults.tsv"
}

list_faults
case ${1:-} in
  --list) awk -F '\t' 'n[$2]++ < $7 { printf "%s, %s, line %d\n  - %s\n  + %s\n", $2, $3, $4, $5, $6 }' "$dir/faults.tsv"; exit ;;
  --score) score; exit ;;
  ?*) echo "usage: tests/mutants.sh [--list | --score]"; exit 2 ;;
esac
build_the_rest
# Without a fault, asked in the same way, no test may fail: the control.
control=control-$header-$TESTS
while
  {
    grep -q "^$control," "$dir/results.csv" || printf "%s\tno room\tcontrol\t0\t-\n" "$control"
    choose
  } >"$dir/todo.tsv"
  [ -s "$dir/todo.tsv" ] && [ "$(date +%s)" -lt "$DEADLINE" ]
do
  seq "$(wc -l <"$dir/todo.tsv")" | xargs -P "$JOBS" -n 1 "$0" --one
done
if grep "^$control,.*,noticed," "$dir/results.csv"; then
  echo "mutants: a test fails for the header as it is"
  exit 1
fi
echo
score
