#!/usr/bin/env bash
# Puts together what bench/leaveout.c counts and measures, object sizes and times of compilation; see its head.
#   leaveout.sh BUILD RESULTS     writes RESULTS/leaveout.csv and .md
#   leaveout.sh --check BUILD     says what must hold, and that controls fail; exit status 1 if not
#   leaveout.sh --everyday BUILD  says what scenes without the everyday things of 0.19.0 pay in BUILD/full over BUILD/before/full
#   leaveout.sh --before BUILD    says what renders under point lights alone cost in BUILD/full over BUILD/before/full, likewise
# BUILD holds programs and objects, named by the switches they were built with. From the Makefile: CC, PROVENANCE (a program), ALL (the name
# with all switches of features), QUERIES (names of objects without renders; the first has one instruction set), SETS (names of
# objects with other instruction sets than those of the default; the first has all).
set -euo pipefail
cd "$(dirname "$0")/.."
check='' before='' everyday=''
[ "${1:-}" != --check ] || check=yes
[ "${1:-}" != --everyday ] || everyday=yes check=yes
[ "${1:-}" != --before ] || before=yes check=yes
[ -z "$check" ] || shift
build=$1
figures=${check:+$build/leaveout.csv}
figures=${figures:-$2/leaveout.csv}
rounds=101

need() { # command, what to install it by
  command -v "$1" >/dev/null || { echo "leaveout: $1 is not installed (make deps-extra), nothing is checked"; exit 1; }
}
row() { printf '%s,%s,%s,%s,%s\n' "$@" >>"$figures"; } # part, name, variant, figure, value

# --- instructions and bytes of one call ---

run() { # name, variant, program, arguments...: under callgrind; it prints what the library reports
  local name=$1 variant=$2 program=$3 out=$build/callgrind.out said bytes each worker isa count
  shift 3
  rm -f "$out"
  # WHY not by a pipe: valgrind writes its file after the program has said everything.
  said=$(valgrind --tool=callgrind --collect-atstart=no --toggle-collect=measured --dump-instr=no \
    --callgrind-out-file="$out" "$build/$program" "$@" 2>"$build/callgrind.log") ||
    { cat "$build/callgrind.log"; exit 1; }
  read -r bytes each worker isa <<<"$said"
  count=$(awk '/^(totals|summary):/ { print $2; exit }' "$out")
  [ "${count:-0}" -gt 0 ] || { echo "leaveout: $name, $variant: no instructions were counted"; exit 1; }
  row cost "$name" "$variant" instructions "$count"
  row cost "$name" "$variant" bytes "$bytes"
  row cost "$name" "$variant" bytes_per_triangle "$each"
  row cost "$name" "$variant" worker "$worker"
  row cost "$name" "$variant" isa "$isa"
}
costs() { # feature, call, what the scene has anyway (or nothing)
  local name="$1 $2${3:+ $3}" without=NO_$1
  [ "$1" != EVERYTHING ] || without=$ALL
  run "$name" full full "$1" without "$2" ${3:+"$3"}
  run "$name" left_out "$without" "$1" without "$2" ${3:+"$3"}
  run "$name" present full "$1" with "$2" ${3:+"$3"}
}
all_costs() {
  local feature call
  for call in render intersect occluded; do
    for feature in MOTION STATS PAPER INSTANCES GROUPS REMOVAL EVERYTHING; do costs $feature $call; done
  done
  for feature in LENS SHUTTER AREA_LIGHTS GLOSS DIELECTRIC CONDUCTOR NORMALS TEXTURES SURFACES; do costs $feature render; done
  costs SHUTTER render moving
  costs SURFACES render textured
  for feature in GLOSS DIELECTRIC CONDUCTOR; do costs $feature render mirror; done
}
past() { # rays past a moving mesh (or through it), counted and raced
  local way kind call name ratio met
  for way in aside across; do
    for kind in coherent incoherent; do
      for call in intersect occluded; do
        run "past ${kind}_$call" "${way}_static" full past $way static $kind $call
        run "past ${kind}_$call" "${way}_moving" full past $way moving $kind $call
      done
    done
    "$build/full" race $way $rounds >"$build/race.txt"
    while read -r name ratio met; do
      row race "$name" $way ratio "$ratio"
      row race "$name" $way met "$met"
    done <"$build/race.txt"
  done
}

# --- objects ---

sizes() {
  local object
  for object in "$build"/*.o; do
    row size "$(basename "$object" .o)" - text "$(size "$object" | awk 'NR == 2 { print $1 }')"
  done
}
compile() { # name, source: user time, the best of three
  local best='' seconds i
  local TIMEFORMAT=%U
  for i in 1 2 3; do
    seconds=$( { time $CC -O2 -std=c99 -ffp-contract=off -w -c "$2" -o "$build/compiled" >&2; } 2>&1 | tail -1)
    best=$(echo "$seconds ${best:-1e9}" | awk '{ print $1 < $2 ? $1 : $2 }')
  done
  row compile "$1" - seconds "$best"
}
compilations() {
  printf '#define PKTRT_IMPLEMENTATION\n#include "%s"\n' "$PWD/pktrt.h" >"$build/compile_pktrt.c"
  printf '#define STB_IMAGE_IMPLEMENTATION\n#include <stb/stb_image.h>\n' >"$build/compile_stb_image.c"
  printf '#include <stdlib.h>\n#include <string.h>\n#include <math.h>\n' >"$build/compile_nothing.c"
  local name
  for name in pktrt stb_image nothing; do compile $name "$build/compile_$name.c"; done
}

# --- what came out ---

# Figures are looked up by part, name, variant and figure.
READ='
  BEGIN { FS = "," }
  !/^#/ {
    v[$1, $2, $3, $4] = $5
    if (!(($1, $2) in seen)) { seen[$1, $2] = 1; n[$1]++; names[$1, n[$1]] = $2 }
  }
  function get(part, name, variant, figure) { # a figure that is not there must not pass for 0
    if (!((part, name, variant, figure) in v)) { print "leaveout: no figure for", part, name, variant, figure; exit 1 }
    if (figure != "isa" && v[part, name, variant, figure] !~ /^[0-9]+([.][0-9]+)?$/) {
      print "leaveout: no number for", part, name, variant, figure ": \"" v[part, name, variant, figure] "\""
      exit 1
    }
    return v[part, name, variant, figure]
  }
  function cost(i, variant, figure) { return get("cost", names["cost", i], variant, figure) }
  function is_past(i) { return names["cost", i] ~ /^past / }
  function more(a, b) { return 100 * (a / b - 1) }
  function past(way, name, at) {
    at = "past " name
    return more(get("cost", at, way "_moving", "instructions"), get("cost", at, way "_static", "instructions"))
  }
  function verdict(controls, claims) { # what nobody measured has not held
    if (!claims || !controls) { print "leaveout:", claims + 0, "claims and", controls + 0, "controls were looked at"; bad++ }
    if (bad) printf "%d of these are not as they should be\n", bad
    exit bad > 0
  }
  function plain(name) { name = tolower(name); gsub(/_/, " ", name); return name }
'

table() {
  awk -v all="$ALL" -v queries="$QUERIES" -v sets="$SETS" "$READ"'
    function words(name, w, n, text) {
      n = split(name, w, " ")
      text = plain(w[1])
      if (n > 2) text = text ", beside " (w[3] == "mirror" ? "a mirror" : w[3] == "moving" ? "motion" : "textures")
      return text " | " w[2]
    }
    function object(name, w) { split(name, w, " "); return w[1] == "EVERYTHING" ? all : "NO_" w[1] }
    function kib(name) { return get("size", name, "-", "text") / 1024 }
    function switches(name) { gsub(/\+/, "`, `", name); return name == "full" ? "none" : "`" name "`" }
    function size_line(name) { printf "| %s | %.0f |\n", switches(name), kib(name) }
    END {
      print "Instructions in one call and bytes for each triangle, of a scene without the feature by the full"
      print "library and by one built without it, and with the feature by the full library; AVX2 kernels. Bytes of a"
      print "worker: while it renders a tile. Code: what the switch takes off the full object, KiB.\n"
      print "| feature | call | full library | built without | full library pays | feature present" \
        " | bytes: full, without, present | a worker: full, without, present | code |"
      print "|---|---|--:|--:|--:|--:|--:|--:|--:|"
      for (i = 1; i <= n["cost"]; i++) {
        if (is_past(i)) continue
        full = cost(i, "full", "instructions"); left_out = cost(i, "left_out", "instructions")
        present = cost(i, "present", "instructions")
        printf "| %s | %d | %d | %+.2f%% | %+.1f%%", words(names["cost", i]), full, left_out, more(full, left_out),
          more(present, full)
        printf " | %.2f, %.2f, %.2f", cost(i, "full", "bytes_per_triangle"),
          cost(i, "left_out", "bytes_per_triangle"), cost(i, "present", "bytes_per_triangle")
        if (cost(i, "full", "worker")) printf " | %d, %d, %d", cost(i, "full", "worker"), cost(i, "left_out", "worker"),
          cost(i, "present", "worker")
        else printf " | "
        printf " | %.1f |\n", kib("full") - kib(object(names["cost", i]))
      }
      print "\nRays past a moving mesh, against the same mesh at rest; and where it is in their way, with the part of"
      print "them that meets its swept bounds. Time is that of the widest vectors; instructions are of AVX2 kernels.\n"
      print "| rays | time | instructions | in their way: time | instructions | meet its bounds |"
      print "|---|--:|--:|--:|--:|--:|"
      for (i = 1; i <= n["race"]; i++) {
        name = names["race", i]
        printf "| %s | %.2fx | %+.1f%%", plain(name), get("race", name, "aside", "ratio"), past("aside", name)
        printf " | %.2fx | %+.1f%%", get("race", name, "across", "ratio"), past("across", name)
        printf " | %.0f%% |\n", 100 * get("race", name, "across", "met")
      }
      print "\nCode of the implementation, -O2:\n"
      print "| switches | KiB |\n|---|--:|"
      size_line("full")
      count = split(sets, q, " ")
      for (i = 1; i <= count; i++) size_line(q[i])
      printf "| all features | %.0f |\n", kib(all)
      count = split(queries, q, " ")
      for (i = 1; i <= count; i++) size_line(q[i])
      pktrt = get("compile", "pktrt", "-", "seconds"); stb = get("compile", "stb_image", "-", "seconds")
      printf "\nCompiling the implementation at -O2 takes %.1f s, stb_image.h %.1f s: %.1fx.\n\n", pktrt, stb,
        pktrt / stb
    }' "$figures"
}

claims() {
  awk -v queries="$QUERIES" -v sets="$SETS" "$READ"'
    function judge(control, sentence, figure, format, bar, aim, details,   held) {
      held = figure <= bar
      if (held == control) bad++
      count[control]++
      printf "%s%s  %s: " format ", wanted at most " format "%s%s\n", control ? "control " : "",
        held ? "ok" : "FAILED", sentence, figure, bar, aim ? " (aim: " aim ")" : "", details ? " (" details ")" : ""
    }
    function instructions(control, i) {
      judge(control, names["cost", i] ": percent of instructions " \
        (control ? "that the feature costs" : "for what is not there"),
        more(cost(i, control ? "present" : "full", "instructions"), cost(i, "left_out", "instructions")), "%.2f", 1)
    }
    function bytes(control, i, figure,   what) {
      what = figure == "worker" ? "bytes of a worker" : plain(figure)
      judge(control, names["cost", i] ": " what (control ? ", with the feature" : ", without it"),
        cost(i, control ? "present" : "full", figure), figure == "worker" ? "%d" : "%.2f", cost(i, "left_out", figure))
    }
    function race(control, way, name) {
      judge(control, "time of " plain(name) " rays " (control ? "through" : "past") " a moving mesh, over that at rest",
        get("race", name, way, "ratio"), "%.3f", 1.05, "", sprintf("%+.2f%% of instructions", past(way, name)))
    }
    function size(control, sentence, name, bar, aim) {
      judge(control, sentence, get("size", name, "-", "text") / 1024, "%.0f", bar, aim)
    }
    END {
      # Triangles weigh the same whatever is called, and a worker is none of a query. Rays pay next to nothing for
      # groups, and for what is hidden.
      for (control = 0; control < 2; control++) {
        for (i = 1; i <= n["cost"]; i++)
          if (!is_past(i) && names["cost", i] !~ (control ? "^(EVERYTHING|REMOVAL|GROUPS)" : "^EVERYTHING")) instructions(control, i)
        for (i = 1; i <= n["cost"]; i++)
          if (names["cost", i] ~ (control ? "^(MOTION|NORMALS|EVERYTHING) render$" : " render"))
            bytes(control, i, "bytes_per_triangle")
        for (i = 1; i <= n["cost"]; i++)
          if (names["cost", i] ~ (control ? "^(DIELECTRIC|CONDUCTOR|GLOSS) render$" : " render"))
            bytes(control, i, "worker")
        split(queries, q, " ")
        split(sets, all_sets, " ")
        size(control, "KiB of code, queries only, one instruction set" (control ? " (but pictures, too)" : ""),
          control ? "full" : q[1], 100, 60)
        size(control, "KiB of code, full" (control ? " (but at -O0)" : ""), control ? "full-O0" : "full", 500, 400)
        size(control, "KiB of code, all instruction sets" (control ? " (but at -O0)" : ""),
          control ? "full-O0" : all_sets[1], 700)
        judge(control, "time to compile, over that of " (control ? "three headers of the C library" : "stb_image.h"),
          get("compile", "pktrt", "-", "seconds") / \
          (get("compile", control ? "nothing" : "stb_image", "-", "seconds") + 1e-3), "%.1f", 10)
      }
      for (i = 1; i <= n["race"]; i++) race(0, "aside", names["race", i])
      race(1, "across", "coherent_intersect"); race(1, "across", "coherent_occluded")
      verdict(count[1], count[0])
    }' "$figures"
}

# Features that nobody asks for choose the mode of the render: MOTION that of WRT, LENS that of DRT.
against_before() {
  local feature light
  for feature in MOTION LENS; do
    for light in '' lights; do
      run "$feature render $light" before before/full $feature without render $light
      run "$feature render $light" now full $feature without render $light
    done
  done
  run "AREA_LIGHTS render" before before/full AREA_LIGHTS without render
  run "AREA_LIGHTS render" now full AREA_LIGHTS with render
}
# What everyday things cost scenes without them, over the header before them, in BUILD/before; and with them, as controls.
against_everyday() {
  local name base call
  while read -r name base; do
    for call in render intersect occluded; do
      [ "$call" = render ] || case $name in BENT | PARALLEL | MATERIALS) continue ;; esac
      run "$name $call $base" before before/full "$name" without $call $base
      run "$name $call $base" now full "$name" without $call $base
      run "$name $call $base" present full "$name" with $call $base
    done
  done <<<'MATERIALS
POOL
RIGID placed
BENT textured
PARALLEL'
}
claims_everyday() {
  awk "$READ"'
    function judge(control, sentence, figure, bar,   held) {
      held = figure <= bar
      if (held == control) bad++
      count[control]++
      printf "%s%s  %s: %.3f, wanted at most %.3f\n", control ? "control " : "", held ? "ok" : "FAILED", sentence, figure, bar
    }
    END {
      for (i = 1; i <= n["cost"]; i++) {
        name = names["cost", i]
        judge(0, name ": percent of instructions over the header before it", more(cost(i, "now", "instructions"),
          cost(i, "before", "instructions")), 0.3)
        judge(0, name ": bytes", cost(i, "now", "bytes"), cost(i, "before", "bytes"))
        judge(0, name ": bytes of a worker", cost(i, "now", "worker"), cost(i, "before", "worker"))
        if (name ~ /^(BENT|PARALLEL|MATERIALS)/)
          judge(1, name ", present: percent of instructions", more(cost(i, "present", "instructions"), cost(i, "before", "instructions")), 0.3)
        if (name ~ /^(RIGID|MATERIALS)/)
          judge(1, name ", present: bytes", cost(i, "present", "bytes"), cost(i, "before", "bytes"))
      }
      verdict(count[1], count[0])
    }' "$figures"
}
claims_before() {
  awk "$READ"'
    END {
      for (i = 1; i <= n["cost"]; i++) {
        name = names["cost", i]; control = name ~ /^AREA/
        figure = more(cost(i, "now", "instructions"), cost(i, "before", "instructions"))
        held = figure <= 1
        if (held == control) bad++
        count[control]++
        printf "%s%s  %s%s, %s: percent of instructions over the version before: %+.3f, wanted at most 1\n",
          control ? "control " : "", held ? "ok" : "FAILED", name ~ /^MOTION/ ? "WRT" : "DRT",
          control ? ", a quad light in place of the point" : name ~ /lights$/ ? ", eight point lights" : ", one point light",
          get("cost", name, "now", "isa"), figure
      }
      verdict(count[1], count[0])
    }' "$figures"
}

need valgrind
if [ -n "$everyday" ]; then
  echo part,name,variant,figure,value >"$figures"
  against_everyday
  claims_everyday
  exit
fi
if [ -n "$before" ]; then
  echo part,name,variant,figure,value >"$figures"
  against_before
  claims_before
  exit
fi
need size
{ if [ -z "$check" ]; then "$PROVENANCE" make leaveout; fi; echo part,name,variant,figure,value; } >"$figures"
all_costs
past
sizes
compilations
if [ -n "$check" ]; then claims; else table | tee "${figures%.csv}.md"; fi
