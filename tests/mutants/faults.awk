# Lists the faults that can be planted in a header: one line each, in the order in which a room has them planted, as
#   room <tab> rank in the room <tab> number of lines of the room that could have one <tab> rule <tab> line <tab> old <tab> new
# usage: awk -v seed=N -f faults.awk LINES HEADER, LINES being the numbers of the lines that are compiled.
#
# A fault is a rule applied to the text of one line within a function (or a constant within an enumeration or a table). Nothing is
# asked of names but words that operations on vectors have in common with their instructions: add, sub, min, max, ... Comments,
# texts, preprocessor lines, declarations, prefetching and functions that only tests call have no faults. Which ones are chosen is a
# hash of the line's shape, that is its text with every name replaced by the same letter: renaming leaves it.

BEGIN {
  for (i = 32; i < 127; i++) code_of[sprintf("%c", i)] = i
  # rule <tab> old <tab> new
  n = split("compare\t < \t <= |compare\t <= \t < |compare\t > \t >= |compare\t >= \t > |compare\t == \t != |compare\t != \t == |" \
            "compare\t_LT_\t_LE_|compare\t_LE_\t_LT_|compare\tlt(\tle(|compare\tle(\tlt(|" \
            "flip\t < \t > |flip\t > \t < |flip\t <= \t >= |flip\t >= \t <= |" \
            "sum\t + \t - |sum\t - \t + |sum\tadd\tsub|sum\tsub\tadd|sum\t += \t -= |sum\t -= \t += |sum\t++\t--|sum\t--\t++|" \
            "product\t * \t / |product\t / \t * |product\tmul\tadd|product\t *= \t /= |product\t /= \t *= |product\t % \t / |" \
            "bits\t << \t >> |bits\t >> \t << |bits\t ^ \t & |bits\t & \t PIPE |bits\t &= \t PIPE= |bits\t ^= \t &= |" \
            "bits\t PIPE \t & |bits\t PIPE= \t &= |" \
            "logic\t && \t PIPEPIPE |logic\t PIPEPIPE \t && |logic\tand\tor|logic\tor\tand|" \
            "extreme\tmin\tmax|extreme\tmax\tmin|truth\ttrue\tfalse|truth\tfalse\ttrue|sign\t!\t|sign\t~\t|sign\t-\t", entry, "|")
  for (i = 1; i <= n; i++) {
    gsub(/PIPE/, "|", entry[i])
    split(entry[i], part, "\t")
    swaps++
    swap_rule[swaps] = part[1]
    swap_old[swaps] = part[2]
    swap_new[swaps] = part[3]
  }
}

function hash(text,    h, i) {
  h = seed * 7919 % 2147483647
  for (i = 1; i <= length(text); i++) h = (h * 131 + code_of[substr(text, i, 1)]) % 2147483647
  for (i = 0; i < 3; i++) h = (h * 48271 + 11) % 2147483647
  return h
}

# --- reading: the header's text, and what of it is code ---

FNR == NR { compiled[$1] = 1; next }
{
  text[FNR] = $0
  last = FNR
  plain = without_comments($0)
  if (match(plain, /^[ \t]*#/) || in_define) {
    if ($0 ~ /^#ifdef PKTRT_IMPLEMENTATION/) implementation = 1
    in_define = $0 ~ /\\$/
    outside = outside " " plain # names in macros are called by whoever uses the macro
    next
  }
  if (match($0, /^\/\* >>[a-z]+/)) room = substr($0, 6, RLENGTH - 5)
  if (!implementation) { outside = outside " " plain; next }
  room_of[FNR] = room
  if (compiled[FNR]) find_bodies(FNR, plain)
}

# Comments become spaces, texts quotes: columns stay.
function without_comments(line,    out, i, two, c) {
  out = ""
  for (i = 1; i <= length(line); i++) {
    c = substr(line, i, 1)
    two = substr(line, i, 2)
    if (in_comment) {
      if (two == "*/") { in_comment = 0; i++; out = out " " }
      out = out " "
    } else if (quote != "") {
      out = out "\""
      if (c == "\\") { i++; out = out "\"" }
      else if (c == quote) quote = ""
    } else if (two == "/*") {
      in_comment = 1; i++; out = out "  "
    } else if (two == "//") {
      break
    } else if (c == "\"" || c == "'") {
      quote = c; out = out "\""
    } else out = out c
  }
  quote = ""
  return out
}

# Follows braces: code[line] has what is within bodies of functions (kind f), of enumerations (e), of initialisers of tables (i).
function find_bodies(line, plain,    i, c, out) {
  out = ""
  kind[line] = within
  for (i = 1; i <= length(plain); i++) {
    c = substr(plain, i, 1)
    if (depth == 0) {
      out = out " "
      if (c == "{") {
        within = head ~ /=[^=]*$/ ? "i" : head ~ /\)[ A-Z_a-z0-9]*$/ ? "f" : head ~ /enum/ ? "e" : ""
        kind[line] = within
        body = within == "f" ? name_of(head) : ""
        if (within != "f") outside = outside " " head
        depth = 1
        head = ""
      } else if (c == ";") {
        if (head ~ /=/) outside = outside " " head # of what is only declared, nobody calls
        head = ""
      } else head = head c
    } else {
      if (c == "{") depth++
      if (c == "}") depth--
      out = out (depth ? c : " ")
    }
  }
  if (depth == 0) head = head " "
  code[line] = out
  of_body[line] = body
  if (body != "") called[body] = called[body] " " out
  else outside = outside " " out
}

# The name of the function that a definition begins with; of NAME(that)(...) it is `that`.
function name_of(head,    at) {
  at = index(head, "(")
  if (match(head, /[A-Z_]+\([A-Za-z_0-9]+\)[ ]*\(/)) {
    head = substr(head, RSTART)
    sub(/^[A-Z_]+\(/, "", head)
    sub(/\).*/, "", head)
    return head
  }
  head = substr(head, 1, at - 1)
  sub(/[ ]*$/, "", head)
  sub(/^.*[ *]/, "", head)
  return head
}

# --- functions that the library calls: what is public, what tables name, and what these call ---

function call(names,    word) {
  while (match(names, /[A-Za-z_][A-Za-z_0-9]*/)) {
    word = substr(names, RSTART, RLENGTH)
    names = substr(names, RSTART + RLENGTH)
    if (!(word in live) && (word in called)) { live[word] = 1; call(called[word]) }
  }
}

# --- planting ---

function plant(rule, at, count, new,    line, whole) {
  line = now
  whole = substr(text[line], 1, at - 1) new substr(text[line], at + count)
  if (whole == text[line] || whole ~ /^[ \t]*$/ || index(whole, "\t")) return
  shape = rule " " nth[rule]++ " " shape_of[line]
  shape = shape " " again[room_of[line], shape]++
  found[room_of[line], ++many[room_of[line]]] = sprintf("%s\t%010d\t%d\t%s\t%s", rule, hash(shape), line, text[line], whole)
  if (!touched[line]++) lines_of[room_of[line]]++
}

# Where the operand that begins at a column ends: before the next separator, or operator that binds less than it.
function operand_end(c, at, ends,    i, deep, x) {
  for (i = at; i <= length(c); i++) {
    x = substr(c, i, 1)
    if (x ~ /[([{]/) deep++
    else if (x ~ /[])}]/) { if (deep-- == 0) return i }
    else if (deep == 0 && (x == "," || x == ";")) return i
    else if (deep == 0 && x == " " && match(substr(c, i), ends) && RSTART == 1) return i
  }
  return 0
}

function closing(c, at,    i, deep) { # of the bracket at a column
  for (i = at; i <= length(c); i++) {
    if (substr(c, i, 1) ~ /[([]/) deep++
    if (substr(c, i, 1) ~ /[])]/ && --deep == 0) return i
  }
  return 0
}

function whole_word(c, at, old,    before, after) {
  before = at > 1 ? substr(c, at - 1, 1) : " "
  after = substr(c, at + length(old), 1)
  if (old ~ /^[a-z]+\(?$/) { # add( vadd( _mm256_add_ps( ..._add8(
    if (before ~ /[A-Za-z0-9]/ && !(at > 2 ? substr(c, at - 2, 2) ~ /[^A-Za-z0-9_][a-z]$/ : 1)) return 0
    if (old ~ /^(true|false)$/) return after !~ /[A-Za-z_0-9]/ && before !~ /[A-Za-z_0-9]/
    return old ~ /\($/ || substr(c, at + length(old)) ~ /^[a-z]?[0-9]*(_[a-z]+[0-9]*)?\(/
  }
  if (old == "!" || old == "~") return after ~ /[A-Za-z_(]/
  if (old == "-") return before ~ /[ (\[]/ && after ~ /[A-Za-z_0-9(]/
  return 1
}

function plant_swaps(c,    i, at, from, new) {
  for (i = 1; i <= swaps; i++) {
    from = 1
    while (at = index(substr(c, from), swap_old[i])) {
      at += from - 1
      from = at + 1
      if (whole_word(c, at, swap_old[i])) plant(swap_rule[i], at, length(swap_old[i]), swap_new[i])
    }
  }
  # the last turn of a loop less, one more
  if (c ~ /for \(.*; .* < .*;/) {
    at = index(c, " < ")
    plant("bound", at, 3, " + 1 < ")
    plant("bound", at, 3, " < 1 + ")
  }
}

function plant_numbers(c, declares,    from, at, number, before, after, new, width) {
  from = 1
  while (match(substr(c, from), /[0-9][0-9A-Za-z_.]*([eEpP][-+][0-9]+f?)?/)) {
    at = from + RSTART - 1
    width = RLENGTH
    number = substr(c, at, width)
    from = at + width
    before = at > 1 ? substr(c, at - 1, 1) : " "
    if (before ~ /[A-Za-z_0-9.]/) continue
    if (number ~ /^0[xX].*[pP]/) new = "(2 * " number ")"
    else if (number ~ /^0[xX]/) new = "(" number " ^ 1)"
    else if (number ~ /[.eE]/) new = number ~ /^0*\.?0*f?$/ ? "1.0f" : "(2 * " number ")"
    else if (declares && before == "[" && substr(c, from) ~ /^\](,|;|\[| =)/) continue
    else new = number ~ /^0/ ? "1" : "(" number (hash(number at) % 2 ? " + 1)" : " - 1)")
    plant("constant", at, width, new)
  }
}

function plant_drops(c,    from, at, end, what, i) {
  # a term, a factor, a condition
  for (i = 1; i <= 2; i++) {
    from = 1
    while (match(substr(c, from), i == 1 ? " [-+] " : " (&&|[|][|]) ")) {
      at = from + RSTART - 1
      from = at + RLENGTH - 1
      end = operand_end(c, from + 1, i == 1 ? "^ ([-+?:<>=!&|^]|<<|>>)" : "^ ([|&][|&]|[?:]) ")
      if (end) plant("drop", at, end - at, "")
    }
  }
  # a statement that has a line of its own
  if (before_ends ~ /[;{}):]$|else$/ && c !~ /^[ ]*(return|if|for|while|do|switch|case|default|goto|else|struct|enum)/ && c ~ /;[ ]*$/) {
    what = c
    sub(/^ */, "", what)
    sub(/ *$/, "", what)
    while (gsub(/\[[^][]*\]/, "", what)) continue
    if (what ~ /^(break|continue);$/ || what ~ /^[^ (]+ ([-+*\/|&^%]|<<|>>)?= / || what ~ /^[^ (=]+(\([a-z_0-9]+\))?\(.*\);$/ || what ~ /^[^ ]+(\+\+|--);$/) {
      match(c, /[^ ]/)
      plant("statement", RSTART, operand_end_of_line(c) - RSTART, "")
    }
  }
}

function operand_end_of_line(c) { sub(/; *$/, "", c); return length(c) + 1 }

function plant_conditions(c,    at, end, from, first, second, inner) {
  from = 1
  while (match(substr(c, from), /(if|while) \(/)) {
    at = from + RSTART - 1 + RLENGTH - 1
    from = at + 1
    end = closing(c, at)
    if (!end) continue
    inner = substr(text[now], at + 1, end - at - 1)
    plant("condition", at, end - at + 1, "(!(" inner "))")
    plant("condition", at, end - at + 1, "(false && (" inner "))")
    plant("condition", at, end - at + 1, "(true || (" inner "))")
  }
  from = 1
  while (match(substr(c, from), / \? /)) { # the other way round
    at = from + RSTART - 1
    from = at + 3
    end = operand_end(c, from, "^ : ")
    if (!end || substr(c, end, 3) != " : ") continue
    first = substr(text[now], from, end - from)
    at = end + 3
    end = operand_end(c, at, "^ : ")
    if (!end) continue
    second = substr(text[now], at, end - at)
    plant("choice", from, end - from, second " : " first)
    plant("choice", from, end - from, first " : " first)
  }
}

function plant_arguments(c,    from, at, middle, end, first, second) {
  from = 1
  while (match(substr(c, from), /[A-Za-z_0-9)]\(/)) {
    at = from + RSTART + 1
    from = at
    if (substr(c, 1, at - 2) ~ /(add|mul|and|or|xor|eq)[0-9]*$/) continue # makes no difference there
    middle = operand_end(c, at, "^never")
    if (!middle || substr(c, middle, 2) != ", ") continue
    end = operand_end(c, middle + 2, "^never")
    if (!end) continue
    first = substr(text[now], at, middle - at)
    second = substr(text[now], middle + 2, end - middle - 2)
    plant("arguments", at, end - at, second ", " first)
  }
}

END {
  call(outside)
  before_ends = ""
  for (now = 1; now <= last; now++) {
    if (!(now in code)) continue
    c = code[now]
    if (kind[now] == "" || c ~ /^[ ]*$/ || tolower(text[now]) ~ /prefetch|fetch\(|static_assert|error/ || (of_body[now] != "" && !(of_body[now] in live))) {
      if (c !~ /^ *$/) { before_ends = c; sub(/ *$/, "", before_ends) }
      continue
    }
    split("", nth)
    squeezed = c
    gsub(/[A-Za-z_][A-Za-z_0-9]*/, "a", squeezed)
    gsub(/ +/, " ", squeezed)
    shape_of[now] = squeezed
    plant_numbers(c, kind[now] == "f" && c ~ /^ *((const|static|unsigned) )*[A-Za-z_][A-Za-z_0-9]* \**[A-Za-z_0-9]+(\[|,|;| =)/)
    if (kind[now] == "f") {
      plant_swaps(c)
      plant_drops(c)
      plant_conditions(c)
      plant_arguments(c)
    }
    before_ends = c
    sub(/ *$/, "", before_ends)
  }
  # In a room each rule has its turn, each time with that of its faults whose hash is least; a line's second fault comes last.
  for (key in many) room_list[++rooms] = key
  for (r = 1; r <= rooms; r++) {
    room = room_list[r]
    count = many[room]
    split("", next_of)
    for (i = 1; i <= count; i++) sorted[i] = found[room, i]
    sort(sorted, count)
    for (i = 1; i <= count; i++) {
      split(sorted[i], part, "\t")
      turn = next_of[part[1]]++
      sorted[i] = sprintf("%06d\t%010d\t%s", turn, part[2] * 48271 % 2147483647, sorted[i])
    }
    sort(sorted, count)
    rank = late = 0
    for (i = 1; i <= count; i++) {
      split(sorted[i], part, "\t")
      if (had[part[5]]++) second[++late] = sorted[i]
      else list(sorted[i])
    }
    for (i = 1; i <= late; i++) list(second[i])
  }
}

function list(fault,    part) {
  split(fault, part, "\t")
  printf "%s\t%d\t%d\t%s\t%d\t%s\t%s\n", room, rank++, lines_of[room], part[3], part[5], part[6], part[7]
}

function sort(of, n,    gap, i, j, x) { # by text
  for (gap = int(n / 2); gap > 0; gap = int(gap / 2)) {
    for (i = gap + 1; i <= n; i++) {
      x = of[i]
      for (j = i; j > gap && of[j - gap] > x; j -= gap) of[j] = of[j - gap]
      of[j] = x
    }
  }
}
