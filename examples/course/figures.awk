# Fills in the figures of a text. A figure is a number followed by its name in a comment, as in 22353<!-- dropped -->. The number
# becomes that of the line `= dropped 22353` in what the program or the check of the text's chapter prints; another chapter's
# figure has a name such as 05_interval/dropped. A decimal in the prose that is no figure is an error, unless it stands in code,
# in a link, behind the word "section", or in a line `<!-- given 0.5 3.1 -->` of the text, for what is no result. The fenced block
# behind a line `<!-- output by bounce -->` becomes what the program of the chapter prints from the line that begins so to the next
# empty one.
# usage: awk -f figures.awk out/course/*.txt NN_name.md. Prints the text; what is wrong goes to standard error, and the exit
# status is 1.

function fail(what) {
  print FILENAME ":" FNR ": " what >"/dev/stderr"
  failed = 1
}

# Returns the value of a figure as printed.
function value(name) {
  if (name !~ /\//) {
    if ((chapter "/" name) in printed) return printed[chapter "/" name]
    name = number "_check/" name
  }
  if (name in printed) return printed[name]
  fail("no program prints the figure " name)
  return "?"
}

# Returns the paragraph of the program's output that begins with `start`.
function output_of(start,    i, text) {
  for (i = 1; i <= lines[chapter]; i++) {
    if (text == "" && index(line_of[chapter, i], start) != 1) continue
    if (line_of[chapter, i] ~ /^(= .*)?$/) break
    text = text line_of[chapter, i] "\n"
  }
  if (text == "") fail("the program prints nothing that begins with \"" start "\"")
  return text
}

# Returns the line with its figures filled in. `prose` becomes the line without figures, code and links.
function fill(line,    done, name, at) {
  prose = ""
  while (match(line, /-?[0-9?][0-9.,]*<!-- [A-Za-z0-9_.\/-]+ -->/)) {
    at = RSTART
    name = substr(line, at, RLENGTH)
    prose = prose substr(line, 1, at - 1)
    done = done substr(line, 1, at - 1)
    line = substr(line, at + RLENGTH)
    sub(/^[^<]*<!-- /, "", name)
    sub(/ -->$/, "", name)
    done = done value(name) "<!-- " name " -->"
  }
  prose = prose line
  return done line
}

# Fails for each decimal in `prose`.
function check_prose(    decimal) {
  gsub(/`[^`]*`/, "", prose)
  gsub(/\]\([^)]*\)/, "]", prose)
  gsub(/[Ss]ections? [0-9.]+(, [0-9.]+)*( and [0-9.]+)?/, "", prose)
  while (match(prose, /[0-9]+\.[0-9]+(\.[0-9]+)*/)) {
    decimal = substr(prose, RSTART, RLENGTH)
    prose = substr(prose, RSTART + RLENGTH)
    if (!(decimal in given)) fail(decimal " is no figure of a program, and not given")
  }
}

FNR == 1 {
  chapter = FILENAME
  sub(/^.*\//, "", chapter)
  sub(/\.(txt|md)$/, "", chapter)
  number = chapter
  sub(/_.*$/, "", number)
}
FILENAME ~ /\.txt$/ {
  if ($1 == "=") printed[chapter "/" $2] = $3
  line_of[chapter, ++lines[chapter]] = $0
  next
}
wanted && /^```/ {
  if (!skipping) print "```\n" output_of(wanted) "```"
  skipping = !skipping
  if (!skipping) wanted = ""
  next
}
skipping { next }
/^<!-- output .* -->$/ {
  wanted = substr($0, 13, length($0) - 16)
  print
  next
}
/^```/ {
  fenced = !fenced
  print
  next
}
/^<!-- given / {
  for (i = 3; i < NF; i++) given[$i] = 1
  print
  next
}
fenced || /^    / || /^#/ || /^<!-- / {
  print
  next
}
{
  print fill($0)
  check_prose()
}
END { exit failed }
