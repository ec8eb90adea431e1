#!/bin/sh
# node_test.sh FOLDER TEST [OTHER_FOLDER...]: runs FOLDER/TEST with the packages that each folder's package-lock.json
# names; missing ones are installed. Exit status 77 (skipped) when they are missing and npm's registry is unreachable, or
# when a program of $NEEDS is missing. The test ends when whoever started this ends.
set -eu
for program in ${NEEDS:-}; do
  [ -x "$program" ] || { echo "SKIPPED: $program is missing; ./dev test installs it (apt-test.txt)"; exit 77; }
done
# Short timeouts: an unreachable registry is noticed in seconds, not minutes.
export NPM_CONFIG_FETCH_RETRY_MINTIMEOUT=1000 NPM_CONFIG_FETCH_RETRY_MAXTIMEOUT=5000
folder=$1 test=$2
shift 2
for each in "$folder" "$@"; do
  cd "$each"
  exec 9<package-lock.json  # several tests need the same packages: the first installs them, the others wait for it
  flock 9
  [ -e node_modules/.package-lock.json ] && [ ! package-lock.json -nt node_modules/.package-lock.json ] && continue
  npm ci --ignore-scripts --no-audit --no-fund --loglevel=error || {
    npm ping --loglevel=error >/dev/null 2>&1 && exit 1
    echo "SKIPPED: npm's registry cannot be reached, so the packages of $each are missing"
    exit 77
  }
  touch node_modules/.package-lock.json
done
exec 9<&-
cd "$folder"
exec setpriv --pdeathsig TERM -- node "$test"
