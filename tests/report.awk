# From CTest's log: every test that failed or was skipped, with what it said. Rooms that died or are no GoogleTest: the
# end of their output.
/^[0-9]+\/[0-9]+ Test: / { room = $3; open = said = is_output = lines = 0 }
/^-+$/ && !is_output { is_output = 1; next }
/^<end of output>$/ { is_output = 0 }
/^Test Failed\.$/ || /^Test Timeout/ {
  if (!said || open) {
    print "FAILED  " room (open ? ": died, or ran out of time, in " name : "") ", whose output ends with"
    for (i = lines > 40 ? lines - 40 : 0; i < lines; ++i) print "  " output[i % 40]
  }
}
!is_output { next }
{ output[lines++ % 40] = $0 }
/^\[ RUN      \] / { name = $4; text = ""; open = 1; next }
/^\[       OK \] / { open = 0; next }
/^\[  (FAILED |SKIPPED) \] / && open {
  print ($2 == "FAILED" ? "FAILED  " : "skipped ") room ": " name
  printf "%s", text
  said = said || $2 == "FAILED"
  open = 0
  next
}
open && length(text) < 4000 { text = text "  " substr($0, 1, 400) "\n" }
