# Worst stack from the compiler's call graphs (-fcallgraph-info=su). Files: a list of the functions whose address is taken,
# then the graphs. One line a level: name, bytes, path.
#
# Calls through pointers and virtual calls carry no target in the graph. Each may go to any function whose address is taken,
# at most three such calls inside each other (document -> character sink -> byte sink). Functions of the
# libraries have no figure and count 128 B. A recursion is an error. A frame is 108 B: 26 registers and alignment.

function bytes(label, part) {
  if (match(label, /[0-9]+ bytes/)) return substr(label, RSTART) + 0
  return -1
}

FNR == NR { taken[$1] = 1; next }
/^node:/ {
  split($0, q, "\"")
  if (bytes(q[4]) >= 0) { if (!(q[2] in size) || bytes(q[4]) > size[q[2]]) size[q[2]] = bytes(q[4]) }
  if ($0 ~ /\(dynamic\)/) { print "unbounded " q[2]; unbounded = 1 }
}
/^edge:/ {
  split($0, q, "\"")
  key = q[2] SUBSEP q[4]
  if (!(key in seen)) { seen[key] = 1; callee[q[2], ++count[q[2]]] = q[4] }
}

function short(name) { sub(/^.*:/, "", name); return name }

# a constructor has two names and one body
function body(f,    other) {
  if (f in size) return f
  other = f
  sub(/C1E/, "C2E", other)
  return other in size ? other : f
}

function depth(f, level,    i, c, d, worst, through, memo) {
  f = body(f)
  if (!(f in size) && f ~ /powbench/ && !(f in missing)) { print "no figure for " f; missing[f] = unbounded = 1 }
  memo = f SUBSEP level
  if (memo in done) return done[memo]
  if (f in active && active[f] > level) { print "recursion " f; unbounded = 1; return 0 }
  active[f] = level + 1
  worst = 0; through = ""
  for (i = 1; i <= count[f]; ++i) {
    c = callee[f, i]
    d = c == "__indirect_call" ? indirect(level) : depth(c, level)
    if (d > worst) { worst = d; through = c == "__indirect_call" ? "* " target[level] : body(c) SUBSEP level }
  }
  delete active[f]
  path[memo] = through
  return done[memo] = worst + (f in size ? size[f] : 128)
}

function indirect(level,    i, d, worst) {
  if (level >= 3) return 0
  if (level in whole) return whole[level]
  worst = 0
  for (i = 1; i <= roots; ++i) {
    d = depth(root[i], level + 1)
    if (d > worst) { worst = d; target[level] = root[i] SUBSEP (level + 1) }
  }
  return whole[level] = worst
}

function trace(f,    text) {
  f = f SUBSEP 0
  while (f != "") {
    if (substr(f, 1, 2) == "* ") { f = substr(f, 3); text = text " *" }
    split(f, part, SUBSEP)
    text = text " " short(part[1])
    f = path[f]
  }
  return text
}

END {
  n = split("run_bench background_handler control_handler samples_handler pvd_handler", entry, " ")
  for (i = 1; i <= n; ++i) is_entry[entry[i]] = 1
  is_entry["reset_handler"] = is_entry["start_up"] = is_entry["stop_handler"] = is_entry["serial_handler"] = is_entry["fault_handler"] = is_entry["fault_reset"] = 1
  for (f in size) if ((short(f) in taken) && !(f in is_entry)) root[++roots] = f
  for (i = 1; i <= n; ++i) {
    if (!(entry[i] in size)) { print "missing " entry[i]; unbounded = 1 }
    d = depth(entry[i], 0) + (i > 1 ? 108 : size["start_up"])
    total += d
    print "level", entry[i], d, ":" trace(entry[i])
  }
  print "total", unbounded ? 0 : total
}
