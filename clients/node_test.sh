#!/bin/sh
# node_test.sh FOLDER TEST: runs FOLDER/TEST with the packages that FOLDER/package-lock.json names, which it installs when
# they are not there. Exit status 77 (skipped) when they are missing and npm's registry cannot be reached.
set -eu
cd "$1"
if [ ! -e node_modules/.package-lock.json ] || [ package-lock.json -nt node_modules/.package-lock.json ]; then
  npm ci --ignore-scripts --no-audit --no-fund --loglevel=error || {
    npm ping --loglevel=error >/dev/null 2>&1 && exit 1
    echo "SKIPPED: npm's registry cannot be reached, so the packages of $1 are missing"
    exit 77
  }
  touch node_modules/.package-lock.json
fi
exec node --test "$2"
