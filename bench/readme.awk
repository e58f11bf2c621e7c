# Fills in the tables of a README: the lines between the marks <!-- NAME --> and <!-- /NAME --> become the table NAME of `results`.
# Most are NAME.md, written with NAME.csv in the same run; those with a function below are made from CSV files here. Under each
# table stands its origin: the first line of its CSV file. A table whose files are missing stays as it is.
# A number in prose that is followed by <!-- NAME -->, as in 1.25<!-- camera -->, becomes the figure NAME of figures.txt, whose head
# says how these are defined. What is not defined, or not one number, is an error, and the exit status is 1.
# A mark may choose from NAME.md: <!-- NAME 1 3 --> takes the first and the third table, each with the text above it, and
# <!-- NAME 1 8x8 --> of the first table only the rows that contain 8x8. Then a link to the whole file follows.

# --- files ---

function path(name) { return results "/" name ".csv" }
function there(names,    n, i, list, line, all) {
  n = split(names, list, " "); all = 1
  for (i = 1; i <= n; i++) { if ((getline line < path(list[i])) <= 0) all = 0; close(path(list[i])) }
  return all
}

# Numbers as numbers: what is cut out of a line would be compared as text.
function value_of(text) { return text ~ /^-?[0-9.]+([eE][-+]?[0-9]+)?$/ ? text + 0 : text }
# The fields of a line, in which quotes may enclose commas, to f by the names of the file's columns.
function read_fields(line, f, columns,    n, i, text, quoted, c, fields) {
  if (!index(line, "\"")) {
    n = split(line, fields, ",")
    for (i = 1; i <= n; i++) f[columns[i]] = value_of(fields[i])
    return
  }
  n = 1; text = ""; quoted = 0
  for (i = 1; i <= length(line) + 1; i++) {
    c = substr(line, i, 1)
    if (c == "\"") quoted = !quoted
    else if (i > length(line) || (c == "," && !quoted)) { f[columns[n]] = value_of(text); n++; text = "" }
    else text = text c
  }
}
# Whether there is a next row of a file; its fields go to f.
function next_row(name, f,    line, columns, n, i) {
  if (!(name in opened)) {
    head_of(name)
    do if ((getline line < path(name)) <= 0) return 0; while (line ~ /^#/)
    opened[name] = line
  }
  if ((getline line < path(name)) <= 0) { close(path(name)); delete opened[name]; return 0 }
  n = split(opened[name], columns, ",")
  read_fields(line, f, columns)
  return 1
}

# --- where figures are from ---

function head_of(name,    line) { # kept: while rows are read the file is open already
  if (!(name in heads)) { heads[name] = (getline line < path(name)) > 0 ? line : ""; close(path(name)) }
  return heads[name]
}
# Version, machine, date or command of a file; what its first line does not say is "unknown".
function origin(name, what,    line, at) {
  line = head_of(name)
  if (line !~ /^# version /) return "unknown"
  at = index(line, what " ")
  if (!at) return "unknown"
  line = substr(line, at + length(what) + 1)
  if (what != "command" && index(line, ";")) line = substr(line, 1, index(line, ";") - 1)
  return line
}
function caption(name,    text) {
  text = "Version " origin(name, "version") "; " origin(name, "machine") "; " origin(name, "date")
  return text "; `" origin(name, "command") "`."
}
# For tables of several files: a cell of each row, and the line below.
function measured(name,    machine) {
  machine = origin(name, "machine")
  if (!(machine in machines)) all_machines = all_machines (all_machines == "" ? "" : "; ") machine
  machines[machine] = 1
  sub(/,.*/, "", machine)
  return origin(name, "version") ", " machine ", " origin(name, "date")
}
function begin_rows(    m) { for (m in machines) delete machines[m]; all_machines = "" }
function end_rows() { print "\nMachines: " all_machines "." }

# --- the first figures of the paper's results ---

function scene_row(what, baseline, paper, name, v,    scenes, i, cells, worst) {
  split("conference rtrt poolhall", scenes, " ")
  for (i = 1; i <= 3; i++) {
    if (v[scenes[i]] == "") { cells = cells " |"; continue }
    cells = cells sprintf(" %.2f |", v[scenes[i]])
    if (worst == "" || v[scenes[i]] < v[worst]) worst = scenes[i]
  }
  worst = sprintf("%.2f, ", v[worst]) (worst == "poolhall" ? "pool hall" : worst)
  print "| " what " | " baseline " | " paper " |" cells " " worst " | " measured(name) ", `" origin(name, "command") "` |"
}
function clear(v,    i) { for (i in v) delete v[i] }
function table_first(    f, paper, fast, widest, v, p, s, quads, beyond, alone) {
  begin_rows()
  print "| times as fast, or as many | as what | the paper | conference | rtrt | pool hall | worst | measured |"
  print "|---|---|--:|--:|--:|--:|---|---|"
  while (next_row("table1", f)) {
    if (f["of"] == "all" && f["path"] == "paper" && f["packet"] == 2) quads[f["scene"]] = f["paper_mrays"] # the last is of packets
    if (f["varied"] == "" && f["of"] == "all" && f["packet"] == 8 && f["assembly"] == "ray types" && f["speedup"] > 0) {
      if (f["path"] == "paper") {
        paper[f["scene"]] = f["speedup"]; p[f["scene"]] = f["paper_speedup"]
        beyond[f["scene"]] = sprintf("%.2f", f["paper_mrays"] / quads[f["scene"]])
      }
      else { fast[f["scene"]] = f["speedup"]; widest = f["isa"] } # the last is the widest
    }
  }
  scene_row("packets of 8x8 by ray type, Whitted's mode, paper path", \
    "single secondary rays of the paper path: one lane of eight works", \
    p["conference"] ", " p["rtrt"] ", " p["poolhall"], "table1", paper)
  scene_row("the same, fast path, " widest, "its single secondary rays, each against eight boxes at once", "", "table1", fast)
  while (next_row("table3", f))
    if (f["of"] == "all" && f["path"] == "paper" && f["samples"] == 64 && f["speedup"] > 0) {
      v[f["scene"]] = f["speedup"]; p["3"] = f["paper_speedup"]
    }
  scene_row("packets of a pixel's 64 samples, distribution ray tracing, paper path",
    "single secondary rays of the paper path", p["3"], "table3", v)
  clear(v)
  while (next_row("section31", f)) if (f["of"] == "all" && f["packets"] == "8x8") v[f["scene"]] = f["over_2x2"]
  scene_row("packets of 8x8 of all rays, paper path: the amortisation of section 3.1", "packets of 2x2, which are SIMD alone",
    beyond["conference"] ", " beyond["rtrt"] ", " beyond["poolhall"], "section31", v)
  clear(v)
  while (next_row("section31", f)) if (f["of"] == "all" && f["packets"] == "8x8") v[f["scene"]] = f["fewer_tests"]
  scene_row("fewer tests of a ray and a box or triangle by packets of 8x8, paper path", "rays traced alone", "", "section31", v)
  clear(v)
  while (next_row("amortisation", f)) {
    if (f["changed_back"] !~ /: the paper.s$/) continue
    s = f["scene"]
    if (f["packets"] == "alone") alone[s] = f["box_tests_per_ray"] + f["triangle_tests_per_ray"]
    if (f["packets"] == "8x8") v[s] = alone[s] / (f["box_tests_per_ray"] + f["triangle_tests_per_ray"])
  }
  scene_row("the same with the paper's steps, lanes, tree and order of pixels", "rays traced alone", "", "amortisation", v)
  clear(v)
  while (next_row("embree_rcs", f)) {
    s = f["scene"]
    if (f["library"] == "pktrt") { paper["rays " s] = f["rays"]; paper["seconds " s] = f["seconds"] }
    else if (!((s " " f["of"]) in fast) || f["seconds"] < fast[s " " f["of"]]) fast[s " " f["of"]] = f["seconds"]
  }
  for (s in p) if (paper["seconds " s] > 0) v[s] = (fast[s " primary"] + fast[s " shadow"]) / paper["seconds " s]
  scene_row("ray casting with all its shading, fast path, " widest, "Embree's fastest mode, which only traces the rays", "",
    "embree_rcs", v)
  end_rows()
}

# --- pictures and other figures ---

function table_pictures(    f, sum, spp, depth, seconds) {
  print "| picture | size | rays per sample | depth of the ray tree | Mrays/s | seconds |"
  print "|---|---|---:|---:|---:|---:|"
  while (next_row("pictures", f)) {
    if (f["counted"] != 1) continue
    sum += f["seconds"]
    spp = f["samples"] > 1 ? ", " f["samples"] " spp" : ""
    depth = f["depth"] > 0 ? sprintf("%.2f", f["depth"]) : "0"
    seconds = sprintf(f["seconds"] < 1 ? "%.2f" : "%.1f", f["seconds"])
    printf "| `%s` %s | %d x %d%s | %.2f | %s | %.1f | %s |\n", f["scene"], f["mode"], f["width"], f["height"], spp,
      f["rays_per_sample"], depth, f["mrays"], seconds
  }
  printf "\nAll nine: %.0f s. ", sum
}

function figure_row(what, command, name, text) { print "| " what " | " command " | " measured(name) " | " text " |" }
function millions(n) {
  if (n < 1e6) return sprintf("%d", n)
  return sprintf(n < 2e7 ? "%.1f million" : "%.0f million", n / 1e6)
}

function rows_of_pictures(    f, one, two) {
  while (next_row("pictures", f)) if (f["counted"] == 0) { if (f["threads"] == 1) one = f["seconds"]; else two = f["seconds"] }
  figure_row("pool hall, ray casting, one thread and two", "`build/render --scene poolhall --spp 1 --no-count --threads 1`, `... 2`",
    "pictures", sprintf("%.2f s, %.2f s (best of three)", one, two))
}
function rows_of_tests(    f) {
  while (next_row("tests", f))
    figure_row("rays compared bit for bit over all ways to ask", "`make test`", "tests",
      sprintf("%.1f million rays, %.1f million answers, %d differ", f["rays"] / 1e6, f["answers"] / 1e6, f["differ"]))
}
function rows_of_stability(    f, n, found, tried, caught, at, ulps, uv) {
  while (next_row("stability", f)) {
    at = f["part"] " " f["what"]
    if (f["kind"] == "count") { n[at] += f["rays"]; found[at] += f["value"] }
    if (f["kind"] == "control" && f["control"] == "Moeller-Trumbore") { tried[at] += f["rays"]; caught[at] += f["value"] }
    if (at != "accuracy 99.9%" || f["case"] !~ /^well-conditioned/) continue
    if (f["case"] ~ /, [uv]$/) { if (f["value"] > uv) uv = f["value"] }
    else if (f["value"] > ulps) ulps = f["value"]
  }
  at = "watertight leaks"
  figure_row("rays aimed at vertices and edges of closed meshes", "`" origin("stability", "command") "`", "stability",
    sprintf("%s rays, %d leak; Moeller-Trumbore, on a part of them: 1 in %.0f", millions(n[at]), found[at],
      tried[at] / caught[at]))
  figure_row("distance of hits from the exact point, 99.9% of well-conditioned rays",
    "`" origin("stability", "command") "`", "stability", sprintf("within %.1f ulps of the largest coordinate; u and v: %.1f", ulps, uv))
}
function rows_of_points(    f, worst, over, at) {
  while (next_row("error_slopes", f)) {
    at = f["kind"] f["dimensions"]
    if (f["sampler"] == "sobol" && (!(at in worst) || f["slope"] > worst[at])) worst[at] = f["slope"]
  }
  figure_row("slope of log RMSE over log samples, Sobol' points, worst: smooth in 1, 2, 4 dimensions; steps in 1, 2, 4",
    "`make error`", "error_slopes", sprintf("%.2f, %.2f, %.2f; %.2f, %.2f, %.2f", worst["smooth1"], worst["smooth2"],
      worst["smooth4"], worst["step1"], worst["step2"], worst["step4"]))
  while (next_row("error_bounds", f)) {
    at = f["dimensions"]
    if (f["sobol"] / f["least"] > over[at]) over[at] = f["sobol"] / f["least"]
  }
  figure_row("RMSE of Sobol' points over the least that any points scrambled alike can have, 2 and 4 dimensions, 4 to 256 samples, at most",
    "`make error`", "error_bounds", sprintf("%.3f, %.3f", over[2], over[4]))
}
function is_drt(scene) { return scene ~ /^(poolhall|conference|rtrt)$/ }
function percent(part, of) { return sprintf("%.1f%%", 100 * part / of) }
function rows_of_estimates(    f, n, rmse, relative, g, reliable, among) {
  while (next_row("error_estimates", f)) {
    g = is_drt(f["scene"])
    n[g] += f["runs"]; rmse[g] += f["runs"] * f["rmse_within"]; relative[g] += f["runs"] * f["relative_within"]
    if (f["unreliable"] < 1) {
      reliable += f["runs"] * (1 - f["unreliable"]); among += f["runs"] * (1 - f["unreliable"]) * f["reliable_within"]
    }
  }
  figure_row("estimated error within 25% of the true one: RMSE, relative MSE", "`make error`", "error_estimates",
    percent(rmse[0] + rmse[1], n[0] + n[1]) ", " percent(relative[0] + relative[1], n[0] + n[1]) " of runs" \
    "; scenes with a closed form: " percent(rmse[0], n[0]) ", " percent(relative[0], n[0]) \
    "; DRT in small pictures: " percent(rmse[1], n[1]) ", " percent(relative[1], n[1]) \
    "; RMSE of those not called unreliable (" percent(reliable, n[0] + n[1]) "): " percent(among, reliable))
}
function rows_of_targets(    f, n, met, m) {
  while (next_row("error_targets", f)) { m = f["measure"]; n[m] += f["runs"]; met[m] += f["runs"] * f["met"] }
  figure_row("render that stops at a target: true error at most 1.15 times as large; RMSE, relative MSE",
    "`make error`", "error_targets",
    percent(met["RMSE"], n["RMSE"]) ", " percent(met["relative MSE"], n["relative MSE"]) " of runs")
}
function pair(ratio, scene) { return sprintf("%.2f, %.2f", ratio[scene, 8], ratio[scene, 16]) }
function rows_of_adaptive(    f, ratio, n, worst, text) {
  while (next_row("error_adaptive", f)) {
    if (f["way"] != "adaptive rmse" || f["time_over_uniform"] == "") continue
    ratio[f["scene"], f["samples"] / 8] = f["time_over_uniform"]
    if (f["samples"] == 64) n++
    if (worst == "" || f["time_over_uniform"] > worst) { worst = f["time_over_uniform"]; text = f["scene"] }
  }
  figure_row("time of adaptive passes of 8 samples over that of one uniform set for the same RMSE, 8 and 16 passes", "`make error`",
    "error_adaptive", "pool hall " pair(ratio, "poolhall") "; conference " pair(ratio, "conference") "; rtrt " pair(ratio, "rtrt") \
    sprintf("; worst of %d scenes %.2f (%s)", n, worst, text))
}
function head_of_figures() {
  begin_rows()
  print "| what | command | measured | figure |\n|---|---|---|---|"
}
function table_figures() {
  head_of_figures()
  rows_of_pictures(); rows_of_tests(); rows_of_stability()
  end_rows()
}
function table_error_figures() {
  head_of_figures()
  rows_of_points(); rows_of_estimates(); rows_of_targets(); rows_of_adaptive()
  end_rows()
}

# --- the README's headline figures ---

function ratio_or_none(value, format) { return value == "" ? "" : sprintf(format, value) }
function table_headline(    f, names, codes, words, n, i, what) {
  n = split("primary;shadow;shadow-from-light;mirror;second-mirror;diffuse;ao;build;refit", codes, ";")
  split("camera rays;shadow rays from surfaces;shadow rays from a light;first mirror rays;second mirror rays;diffuse rays;" \
    "ambient occlusion rays;building the tree, ms;refitting the tree, ms", words, ";")
  for (i = 1; i <= n; i++) names[codes[i]] = words[i]
  print "| Mrays/s on one core | Embree | pktrt | ratio | ratio, single calls | ratio, moving |\n|---|---:|---:|---:|---:|---:|"
  while (next_row("headline", f)) {
    what = f["what"]
    if (what in names) what = names[what]
    else if (f["unit"] == "s") what = what ", two threads, s"
    printf "| %s | %s | %s | %s | %s | %s |\n", what, ratio_or_none(f["embree"], "%.1f"),
      ratio_or_none(f["pktrt"], f["pktrt"] < 1 ? "%.2f" : "%.1f"),
      ratio_or_none(f["ratio"], "%.2f"), ratio_or_none(f["single"], "%.2f"), ratio_or_none(f["moving"], "%.2f")
  }
  print ""
}

# --- single calls against Embree's ---

# Of each scene the geometric mean of the kinds of rays and the worst, of rays that lie in memory and of fresh ones, by both sets.
function table_peers_single(    f, key, scenes, n, i, k, keys, logs, worst, count, names, cell, all, ns, row) {
  split("avx512 single;avx512 fresh;avx2 single;avx2 fresh", keys, ";")
  while (next_row("peers", f)) {
    if (f["mode"] != "single" && f["mode"] != "fresh") continue
    if (f["scene"] == "few triangles") {
      key = f["what"] " " f["isa"] " " f["mode"]
      if (f["library"] == "ratio") ns[key] = ns[key] sprintf(" ns: %.2f", f["best"])
      else ns[key] = ns[key] (ns[key] == "" ? "" : " / ") sprintf("%.1f", f["best"])
    } else if (f["library"] == "ratio" && f["setting"] == "at rest" && f["scene"] != "mean") {
      if (!(f["scene"] in names)) { names[f["scene"]] = 1; scenes[++n] = f["scene"] }
      key = f["scene"] " " f["isa"] " " f["mode"]
      logs[key] += log(f["best"]); count[key]++
      if (!(key in worst) || f["best"] < worst[key]) worst[key] = f["best"]
    }
  }
  print "| scene | AVX-512, stored | fresh | AVX2, stored | fresh |\n|---|--:|--:|--:|--:|"
  for (i = 1; i <= n; i++) {
    row = "| " scenes[i] " |"
    for (k = 1; k <= 4; k++) {
      key = scenes[i] " " keys[k]
      if (!count[key]) { row = row "  |"; continue }
      cell = logs[key] / count[key]
      all[k] += cell
      row = row sprintf(" %.2f (%.2f) |", exp(cell), worst[key])
    }
    print row
  }
  row = "| all |"
  for (k = 1; k <= 4; k++) row = row sprintf(" **%.2f** |", exp(all[k] / n))
  print row
  for (i = 1; i <= 2; i++) {
    row = "| few triangles, a " (i == 1 ? "miss" : "hit") " |"
    for (k = 1; k <= 4; k++) row = row " " ns[(i == 1 ? "miss " : "hit ") keys[k]] " |"
    print row
  }
  print ""
}

# --- stability: a row for each part ---

function table_stability_parts(    f, parts, n, i, p, cases, tried, found, control, caught) {
  while (next_row("stability", f)) {
    p = f["part"]
    if (f["kind"] != "count" && f["kind"] != "control") continue
    if (!(p in tried)) { parts[++n] = p; tried[p] = 0 }
    if (f["kind"] == "count") { cases[p]++; tried[p] += f["rays"]; found[p] += f["value"] }
    else { control[p] += f["rays"]; caught[p] += f["value"] }
  }
  print "| part | counts | rays or tries | faults found | rays or tries of the controls | faults found there |"
  print "|---|--:|--:|--:|--:|--:|"
  for (i = 1; i <= n; i++) {
    p = parts[i]
    printf "| %s | %d | %s | %d | %s | %s |\n", p, cases[p], millions(tried[p]), found[p], millions(control[p]), millions(caught[p])
  }
  print ""
}

function table_fuzz(    f, feeds) {
  feeds["scene"] = "calls in any order, bad meshes, failing allocations, against a model of what must be refused"
  feeds["query"] = "rays of any bits on small scenes, all paths and instruction sets, against brute force"
  feeds["settings"] = "cameras, lights, materials, render settings, against a model; all ways to render, same bits"
  feeds["mesh_file"] = "`.tri` files"
  print "| target | what it feeds | seconds | inputs tried |\n|---|---|--:|--:|"
  while (next_row("fuzz", f)) printf "| %s | %s | %d | %d |\n", f["target"], feeds[f["target"]], f["seconds"], f["inputs"]
  print ""
}

# Of what was not there a cell says so.
function table_checksums(    f, sum) {
  print "| where | by | checksum |\n|---|---|---|"
  while (next_row("checksums", f)) {
    sum = f["checksum"]
    printf "| %s | %s | %s |\n", f["where"], f["by"], sub(/^0x/, "", sum) ? "`" sum "`" : sum
  }
  print ""
}

# --- figures in prose ---

function fail(what) {
  print FILENAME ":" FNR ": " what >"/dev/stderr"
  failed = 1
}
# Reads figures.txt. Of each figure: how its rows are put together, its format, its file and column, and what its rows have.
function read_definitions(    file, line, word, n, i, name, column) {
  file = source "/figures.txt"
  defined = 1
  while ((getline line < file) > 0) {
    if (line ~ /^(#|$)/) continue
    n = split(line, word, " ")
    name = word[1]
    if (name in how) fail(file " defines " name " twice")
    how[name] = word[2]
    format[name] = word[3]
    split(word[4], column, ".")
    from[name] = column[1]
    number[name] = column[2]
    for (i = 5; i <= n; i++) condition[name, i - 4] = word[i]
    conditions[name] = n - 4
    names_from[column[1], ++figures_from[column[1]]] = name
  }
  close(file)
}
# Whether a row has what the figure asks for: COLUMN=VALUE,VALUE or COLUMN!=VALUE. Blanks in values are written as underscores.
function is_of(name, f,    i, part, value, differs) {
  for (i = 1; i <= conditions[name]; i++) {
    differs = condition[name, i] ~ /!=/
    split(condition[name, i], part, /!?=/)
    if (!(part[1] in f)) { fail(from[name] ".csv has no column " part[1] ", which " name " asks for"); return 0 }
    value = f[part[1]] ""
    gsub(/ /, "_", value)
    if (differs == (index("," part[2] ",", "," value ",") > 0)) return 0
  }
  return 1
}
# Takes all figures of a file from its rows. A column A/B is the quotient of two.
function take_figures(file,    f, i, name, x, part) {
  taken[file] = 1
  while (next_row(file, f))
    for (i = 1; i <= figures_from[file]; i++) {
      name = names_from[file, i]
      if (!is_of(name, f)) continue
      x = f[number[name]]
      if (split(number[name], part, "/") == 2) x = f[part[2]] + 0 ? f[part[1]] / f[part[2]] : ""
      if (x == "") continue
      if (!rows_of[name]++) least[name] = most[name] = x
      if (x < least[name]) least[name] = x
      if (x > most[name]) most[name] = x
      sum[name] += x
      if (x > 0) logs[name] += log(x)
      else if (how[name] == "mean") fail(name " is a geometric mean of what is not above 0")
    }
}
# The figure as it stands in the text.
function figure(name,    x, shown) {
  if (!defined) read_definitions()
  if (!(name in how)) { fail("figures.txt does not define " name); return "?" }
  if (!(from[name] in taken)) take_figures(from[name])
  if (!rows_of[name]) { fail("no row of " from[name] ".csv has the figure " name); return "?" }
  if (how[name] == "only" && least[name] != most[name]) fail("the rows of " from[name] ".csv differ in the figure " name)
  if (how[name] ~ /^(only|least)$/) x = least[name]
  else if (how[name] == "most") x = most[name]
  else if (how[name] == "sum") x = sum[name]
  else if (how[name] == "mean") x = exp(logs[name] / rows_of[name])
  else fail("figures.txt puts " name " together in an unknown way, " how[name])
  shown = format[name]
  if (sub(/%%$/, "", shown)) return sprintf(shown, 100 * x)
  if (sub(/M$/, "", shown)) return sprintf(shown, x / 1e6)
  if (sub(/ppm$/, "", shown)) return sprintf(shown, x * 1e6)
  return sprintf(shown, x)
}
function fill(line,    done, name, at) {
  while (match(line, /-?[0-9?][0-9.,]*<!-- [a-z0-9_]+ -->/)) {
    at = RSTART
    name = substr(line, at, RLENGTH)
    done = done substr(line, 1, at - 1)
    line = substr(line, at + RLENGTH)
    sub(/^[^<]*<!-- /, "", name)
    sub(/ -->$/, "", name)
    done = done figure(name) "<!-- " name " -->"
  }
  return done line
}

# --- the marks ---

BEGIN {
  if (source == "") source = "bench"
  needs["first"] = "table1 table3 section31 amortisation embree_rcs"
  needs["figures"] = "pictures tests stability"
  needs["error_figures"] = "error_slopes error_bounds error_estimates error_targets error_adaptive"
  needs["pictures"] = "pictures"; needs["headline"] = "headline"; needs["stability_parts"] = "stability"; needs["fuzz"] = "fuzz"
  needs["checksums"] = "checksums"; needs["peers_single"] = "peers"
}
# The lines of NAME.md, or those that a mark chooses: `blocks` are numbers of tables between blanks, or none for all; `rows` is
# what a row must contain.
function table_of_file(name, blocks, rows,    file, line, blank, block, in_table, row, shown) {
  file = results "/" name ".md"
  block = blank = 1
  while ((getline line < file) > 0) {
    if (line !~ /^\|/ && in_table) { in_table = row = 0; block++ }
    if (line ~ /^\|/) { in_table = 1; row++ }
    shown = blocks == " " || index(blocks, " " block " ")
    if (shown && in_table && row > 2 && rows != "") shown = index(line, rows) > 0
    if (!shown || (line == "" && blank)) continue
    print line
    blank = line == ""
  }
  close(file)
  if (!blank) print ""
}
function table(name, blocks, rows,    where) {
  print ""
  if (name == "first") table_first()
  else if (name == "figures") table_figures()
  else if (name == "error_figures") table_error_figures()
  else if (name == "pictures") table_pictures()
  else if (name == "headline") table_headline()
  else if (name == "peers_single") table_peers_single()
  else if (name == "stability_parts") table_stability_parts()
  else if (name == "fuzz") table_fuzz()
  else if (name == "checksums") table_checksums()
  else table_of_file(name, blocks, rows)
  where = FILENAME ~ /bench\/README\.md$/ ? "results/" : "../results/"
  if (name == "stability_parts") print caption("stability") " [All of it](" where "stability.md)."
  else if (name !~ /^(first|figures|error_figures)$/)
    print caption(name == "peers_single" ? "peers" : name) (blocks == " " ? "" : " [All of it](" where name ".md).")
  print ""
}
function can(name,    line, ok) {
  if (name in needs) return there(needs[name])
  ok = (getline line < (results "/" name ".md")) > 0
  close(results "/" name ".md")
  return ok && there(name)
}
inside && $0 == "<!-- /" name " -->" { inside = 0 }
!inside { print fill($0) }
/^<!-- [a-z0-9_]+( [^ ]+)* -->$/ && !inside {
  name = $2; blocks = " "; rows = ""
  for (i = 3; i < NF; i++) { if ($i ~ /^[0-9]$/) blocks = blocks $i " "; else rows = $i }
  if (can(name)) { inside = 1; table(name, blocks, rows) }
}
END { exit failed }
