#!/usr/bin/env bash
# Makes the recordings of tests/golden anew; see README.md beside it for when that is right.
#   tests/golden/make.sh [BUILD_FOLDER]     default: build/release
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
oos=$(readlink -f "${1:-build/release}")/bin/oos
new=$(mktemp -d)
trap 'rm -rf "$new"' EXIT

# record NAME SCENARIO BEGIN_S END_S
record() {
  # The run ends at the recording's end, long before the procedure's: status 1.
  "$oos" run "scenarios/module_replacement/$2" --lockstep --seed 1 --steps "$new/steps.mcap" --steps_from "$3" \
    --duration "$4" --out "$new/run" || [ $? -eq 1 ]
  "$oos" replay "$new/steps.mcap" --check
  mv "$new/steps.mcap" "tests/golden/$1.mcap"
  ls -l "tests/golden/$1.mcap"
  rm -r "$new/run"
}
record module_replacement paper.xml 35.9 36.9
record module_replacement_default scenario.xml 36.1 36.9
