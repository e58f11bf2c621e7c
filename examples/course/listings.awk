# Fills in the listings of a text: the fenced block behind a line `<!-- listing FILE name -->` becomes the code that stands in
# FILE, beside the text, between the lines `/* [name] */` and `/* [end] */`. usage: awk -f listings.awk NN_name.md. Prints the
# text; what is wrong goes to standard error, and the exit status is 1.

function fail(what) { print FILENAME ":" FNR ": " what >"/dev/stderr"; failed = 1 }

# Prints the part, without the indentation of its first line. Returns how many lines it has.
function listing(file, name,    path, line, n, on, indent, got) {
  path = FILENAME
  sub(/[^\/]*$/, file, path)
  while ((got = (getline line < path)) > 0) {
    if (line ~ /^ *\/\* \[end\] \*\/$/) on = 0
    if (on) {
      if (!n++) { match(line, /^ */); indent = RLENGTH }
      print line ~ /^ *$/ ? "" : substr(line, 1, indent) ~ /^ *$/ ? substr(line, indent + 1) : line
    }
    if (line == "/* [" name "] */" || line ~ "^ *[/][*] \\[" name "\\] [*][/]$") on = 1
  }
  close(path)
  if (got < 0) fail(file " is not there")
  else if (!n) fail(file " has no part [" name "]")
  else if (on) fail("[" name "] of " file " has no end")
  return n
}

# The fenced block of before is dropped; the new one stands in its place.
wanted && /^```/ {
  if (!skipping) { skipping = 1; next }
  print "```c"
  listing(file, name)
  print "```"
  wanted = skipping = 0
  next
}
skipping { next }
wanted { fail("a fenced block is to follow a listing's mark"); wanted = 0 }
{ print }
/^<!-- listing / {
  wanted = $0 ~ /^<!-- listing [A-Za-z0-9_.]+ [A-Za-z0-9_]+ -->$/
  file = $3; name = $4
  if (!wanted) fail("not of the form <!-- listing FILE name -->")
  if (file ~ /_solution/) fail("a listing shows a solution")
}
END {
  if (wanted) fail("the last listing has no fenced block, or no end of it")
  exit failed
}
