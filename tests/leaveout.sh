#!/usr/bin/env bash
# The switches PKTRT_NO_...: each alone and all together compile without a warning; what is left out is refused by a sentence that
# names its switch, or does not compile; what is not left out keeps its bits. From the project's directory; JOBS=1 for one core.
set -u
cd "$(dirname "$0")/.." || exit 1
work=build/switches
program=tests/leaveout/program.c
flags="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -ffp-contract=off"
# Switches leave sets out though they are asked for. What is built when nothing is, has not got these two.
ask="-DPKTRT_SCALAR -DPKTRT_AVX512"
unasked="PKTRT_NO_SCALAR PKTRT_NO_AVX512"
# Two sets of instructions are enough where it is features that are left out, and take half the time, as clang -O0 does, where it is
# installed; that all four compile is seen without making code.
quick=$(command -v clang >/dev/null && echo "clang -O0" || echo "gcc -O1")
narrow="PKTRT_NO_AVX2 PKTRT_NO_AVX512"
pictures="PKTRT_NO_LENS PKTRT_NO_SHUTTER PKTRT_NO_AREA_LIGHTS PKTRT_NO_GLOSS PKTRT_NO_DIELECTRIC PKTRT_NO_CONDUCTOR
  PKTRT_NO_NORMALS PKTRT_NO_TEXTURES"
features=$(echo PKTRT_NO_MOTION PKTRT_NO_STATS PKTRT_NO_PAPER PKTRT_NO_INSTANCES PKTRT_NO_GROUPS PKTRT_NO_REMOVAL PKTRT_NO_SURFACES \
  PKTRT_NO_POOLS PKTRT_NO_CLOSEST PKTRT_NO_QUALITIES $pictures)

# A line for each build: what is left out. The first is the full library; `unasked` asks for no set.
builds() {
  echo
  for one in PKTRT_NO_RENDER $features; do echo "$one $narrow"; done
  echo "$features"
  echo "PKTRT_NO_RENDER $features"
  printf '%s\n' PKTRT_NO_AVX2 PKTRT_NO_AVX512 PKTRT_NO_SIMD PKTRT_NO_FRUSTA "PKTRT_NO_SCALAR PKTRT_NO_SSE2" unasked
}
folder_of() { echo "$work/$(printf '%s' "full $1" | tr -s ' ' '\n' | sed 's/^PKTRT_NO_//' | paste -sd - | cut -c 1-200)"; }
options_of() {
  local one
  [ "$1" != unasked ] || return 0
  printf ' %s' "$ask"
  for one in $1; do printf ' -D%s' "$one"; done
}

attempt() { # what, command...: prints the outcome as one piece, with the compiler's words if it failed
  local what=$1 out
  shift
  if out=$("$@" 2>&1); then
    echo "passed  $what"
  else
    printf 'FAILED  %s\n        %s\n%s\n' "$what" "$*" "$(printf '%s\n' "$out" | head -20)"
  fi
}

# --- with --build and a line of switches: one build, and what it prints ---

# shellcheck disable=SC2046,SC2086
if [ "${1:-}" = --build ]; then
  switches=${2# } folder=$(folder_of "${2# }") name=${2:-nothing}
  options=$(options_of "$switches")
  mkdir -p "$folder"
  rm -f "$folder/text"
  attempt "${quick%% *}, without $name" $quick -std=c99 $flags $options $program -o "$folder/program" -lm
  "$folder/program" >"$folder/new" && mv "$folder/new" "$folder/text"
  # Features are compiled for all sets here; it is warnings that are looked for.
  [ "${switches% "$narrow"}" = "$switches" ] || options=$(options_of "${switches% "$narrow"}")
  # One compiler of each language and each kind for one switch, all four for none and for all of them.
  case " $switches " in "  " | *" PKTRT_NO_LENS "*PKTRT_NO_GLOSS*) set -- "clang -std=c99" "g++ -x c++ -std=c++11" ;; *) set -- ;; esac
  for compiler in "gcc -std=c99" "clang++ -x c++ -std=c++11" "$@"; do
    command -v ${compiler%% *} >/dev/null || continue
    attempt "${compiler%% *}, without $name" $compiler -fsyntax-only $flags $options $program
  done
  exit 0
fi

# --- judging what they printed ---

# Beside the full library's lines: what is left out is refused by name, all else is the same. Prints what is wrong.
judge() { # switches, the full library's text, the build's text
  awk -F '\t' -v given="$1" '
    function complain(words) { print "        " $2 ": " words; bad = 1 }
    BEGIN { n = split(given, list, " "); for (i = 1; i <= n; i++) on[list[i]] = 1; queries = "PKTRT_NO_RENDER" in on }
    FNR == 1 { next } # what was built
    NR == FNR { full[$2] = $3; next }
    {
      seen[$2] = 1; n = split($1, own, " "); out = ""; named = 0
      for (i = 1; i <= n; i++) if (own[i] in on) { out = own[i]; if (index($3, own[i])) named = 1 }
      want = full[$2]; got = $3
      if ($2 == "normals" && out) { want = full["normals not looked at"]; out = "" } # stored by nobody
      if ($2 == "surfaces with normals" && out == "PKTRT_NO_NORMALS") { want = full["surfaces"]; out = "" }
      if (queries) { sub(/ .*/, "", want); sub(/ .*/, "", got) }
      if (out == "" && got != want) complain("expected " want ", got " $3)
      else if (out != "" && $3 != "left out" && !($3 ~ /^refused: / && named)) complain("expected a refusal by " out ", got " $3)
    }
    END {
      for (name in full) if (!(name in seen) && !queries) { $2 = name; complain("is missing") }
      if (length(seen) < 8) { $2 = "all"; complain("not enough lines") }
      exit bad
    }' "$2" "$3"
}

# What the report must say that a build has not.
not_built() { # switches
  local name switch list="not built"
  while read -r switch name; do
    case " $1 " in *" PKTRT_NO_$switch "* | *" PKTRT_NO_RENDER "*) ;; *) continue ;; esac
    case $switch in MOTION | STATS | PAPER | NORMALS | INSTANCES | GROUPS | REMOVAL | SURFACES) [ "${1/PKTRT_NO_$switch/}" != "$1" ] || continue ;; esac
    list="$list, $name"
  done <<'FEATURES'
MOTION motion
STATS stats
PAPER paper path
RENDER render
RENDER mirror
DIELECTRIC dielectric
CONDUCTOR conductor
GLOSS gloss
NORMALS normals
TEXTURES textures
AREA_LIGHTS area lights
LENS lens
SHUTTER shutter
INSTANCES instances
GROUPS groups
REMOVAL removal
SURFACES surfaces
FEATURES
  echo "$list"
}

full=$(folder_of "")/text
as_it_must_be() { # switches
  local text
  text=$(folder_of "$1")/text
  [ -s "$text" ] || { echo "it printed nothing"; return 1; }
  [ "$(head -1 "$text")" = "$(not_built "$1")" ] || { echo "expected: $(not_built "$1")"; head -1 "$text"; return 1; }
  judge "${1/#unasked/$unasked}" "$full" "$text"
}
fails() { # command...: not just anyhow
  "$@"
  [ $? = 1 ]
}
pictures_differ() { # the full library's, but for nine that must be as others: a case that changes nothing shows nothing
  local kinds
  kinds=$(awk -F '\t' '$3 ~ /^[0-9a-f]+ [0-9a-f]+$/ {print $3}' "$full" | sort -u | wc -l)
  echo "$kinds different"
  [ "$kinds" = $(($(grep -c '	[0-9a-f]* [0-9a-f]*$' "$full") - 9)) ]
}

# --- what does not compile ---

declared_unless() { # switch: names of functions that the header declares only without it, and types with their pktrt_
  awk -v begin="#ifndef $1" '
    /^\/\* stop here/ { exit }
    $0 == begin { on = 1; next }
    on && /^#if/ { on++ }
    on && /^#endif/ { on-- }
    on && /^PKTRT_DEF/ { sub(/\(.*/, ""); sub(/.*[ *]/, ""); print "(void)&" $0 }
    on && /^} [a-z]/ { sub(/^} /, ""); sub(/;.*/, ""); print "(void)sizeof(" $0 ")" }' pktrt.h
}
does_not_compile() { # statement, switch: and without the switch it does
  local file=$work/call.c
  printf '#include "../../pktrt.h"\nint main(void) {\n  %s;\n  return 0;\n}\n' "$1" >"$file"
  set -- "$2" gcc -std=c99 -Werror=implicit-function-declaration -fsyntax-only "$file"
  "${@:2}" || return 1
  ! "${@:2}" "-D$1" 2>"$work/call.txt" && grep -q 'error:.*\(undeclared\|implicit declaration\|unknown type\)' "$work/call.txt"
}
calls_do_not_compile() { # switch, and how many there are at least
  local statement n=0
  while read -r statement; do
    does_not_compile "$statement" "$1" || { echo "$statement compiles with $1, or not at all"; return 1; }
    n=$((n + 1))
  done < <(declared_unless "$1")
  echo "$n names"
  [ $n -ge "$2" ]
}
contradiction() { # switch, what of it comes before the declarations, and before the implementation: #define or #undef
  printf '%s\n' "$2 $1" '#include "../../pktrt.h"' "$3 $1" '#define PKTRT_IMPLEMENTATION' '#include "../../pktrt.h"' \
    >"$work/contradiction.c"
  gcc -std=c99 -fsyntax-only "$work/contradiction.c" 2>"$work/contradiction.txt"
}
# The implementation with other switches than the declarations before it in the same file: an #error with advice.
contradictions_are_refused() { # switch
  local order
  for order in '#undef #define' '#define #undef'; do
    # shellcheck disable=SC2086
    if contradiction "$1" $order; then echo "${order% *}, then ${order#* } $1: it compiles"; return 1; fi
    grep -q "#error.*$1" "$work/contradiction.txt" || { head -3 "$work/contradiction.txt"; return 1; }
  done
  contradiction "$1" '#undef' '#undef' && contradiction "$1" '#define' '#define' # the controls
}

# --- all of it ---

mkdir -p "$work"
log=$work/log
builds | tr '\n' '\0' | xargs -0 -P "${JOBS:-$(nproc)}" -n 1 "$0" --build >"$log"
{
  while read -r switches; do
    attempt "as it must be without ${switches:-nothing}" as_it_must_be "$switches"
  done < <(builds)
  attempt "cases of the full library have pictures of their own" pictures_differ
  motion=$(folder_of "PKTRT_NO_MOTION $narrow")/text
  attempt "control: what is refused though it was not left out is seen" fails judge "$narrow" "$full" "$motion"
  attempt "control: what is not refused though it was left out is seen" fails judge PKTRT_NO_MOTION "$full" "$full"
  attempt "control: what nobody asked for is missed where it was asked for" fails judge "" "$full" "$(folder_of unasked)/text"
  attempt "control: a refusal that names another switch is seen" fails judge "PKTRT_NO_MOTION $narrow" "$full" \
    <(sed 's/PKTRT_NO_MOTION$/PKTRT_NO_LENS/' "$motion")
  attempt "control: another bit is seen" fails judge "" "$full" <(sed '/^-	mirror/ s/.$/g/' "$full")
  attempt "control: a missing case is seen" fails judge "" "$full" <(sed '/^-	mirror/ d' "$full")
  attempt "a call of what PKTRT_NO_RENDER leaves out does not compile" calls_do_not_compile PKTRT_NO_RENDER 30
  attempt "a call of what PKTRT_NO_NORMALS leaves out does not compile" calls_do_not_compile PKTRT_NO_NORMALS 1
  attempt "a call of what PKTRT_NO_INSTANCES leaves out does not compile" calls_do_not_compile PKTRT_NO_INSTANCES 6
  attempt "a call of what PKTRT_NO_REMOVAL leaves out does not compile" calls_do_not_compile PKTRT_NO_REMOVAL 3
  attempt "a call of what PKTRT_NO_SURFACES leaves out does not compile" calls_do_not_compile PKTRT_NO_SURFACES 5
  attempt "a call of what PKTRT_NO_CLOSEST leaves out does not compile" calls_do_not_compile PKTRT_NO_CLOSEST 4
  attempt "nor does a call without a declaration" does_not_compile "pktrt_set_normals(0, 0, 0, 0)" PKTRT_NO_NORMALS
  attempt "contradicting PKTRT_NO_RENDER is an #error that names it" contradictions_are_refused PKTRT_NO_RENDER
  attempt "contradicting PKTRT_NO_NORMALS is an #error that names it" contradictions_are_refused PKTRT_NO_NORMALS
} >>"$log"
grep -v '^passed ' "$log"
good=$(grep -c '^passed ' "$log") bad=$(grep -c '^FAILED ' "$log")
echo "leaveout: $(builds | wc -l) builds; $good passed, $bad failed"
[ "$good" -gt 0 ] && [ "$bad" = 0 ]
