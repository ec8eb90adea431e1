#!/usr/bin/env bash
# Makes tests/golden/module_replacement.mcap anew; see README.md beside it for when that is right.
#   tests/golden/make.sh [BUILD_FOLDER]     default: build/release
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/../.."
oos=$(readlink -f "${1:-build/release}")/bin/oos
golden=tests/golden/module_replacement.mcap
new=$(mktemp -d)
trap 'rm -rf "$new"' EXIT
# The run ends at the recording's end, long before the procedure's: status 1.
"$oos" run scenarios/module_replacement/paper.xml --lockstep --seed 1 --steps "$new/steps.mcap" --steps_from 35.9 --duration 36.9 \
  --out "$new/run" || [ $? -eq 1 ]
"$oos" replay "$new/steps.mcap" --check
mv "$new/steps.mcap" "$golden"
ls -l "$golden"
