# Reads CTest's log and prints every test that failed or was skipped, with its output. For programs that crashed or do not
# use GoogleTest: their "not ok" lines (TAP) and the end of their output.
/^[0-9]+\/[0-9]+ Test: / { room = $3; wrong = ""; open = said = is_output = lines = num_wrong = 0 }
/^-+$/ && !is_output { is_output = 1; next }
/^<end of output>$/ { is_output = 0 }
/^Test Failed\.$/ || /^Test Timeout/ {
  if (!said || open) {
    if (wrong) printf "FAILED  %s\n%s", room, wrong
    print "FAILED  " room (open ? ": died, or ran out of time, in " name : "") ", whose output ends with"
    for (i = lines > 40 ? lines - 40 : 0; i < lines; ++i) print "  " output[i % 40]
  }
}
!is_output { next }
{ output[lines++ % 40] = $0 }
/^ *not ok / { num_wrong = 16 }
num_wrong > 0 { --num_wrong; wrong = wrong "  " substr($0, 1, 400) "\n" }
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
