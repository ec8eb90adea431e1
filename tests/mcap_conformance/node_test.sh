#!/bin/sh
# node_test.sh FROM TO TEST: runs FROM/TEST from the folder TO, with the packages that FROM/package-lock.json names; installs
# them there when they are missing. Exit status 77 (skipped) when npm's registry cannot be reached.
set -eu
# Short timeouts: an unreachable registry is noticed in seconds, not minutes.
export NPM_CONFIG_FETCH_RETRY_MINTIMEOUT=1000 NPM_CONFIG_FETCH_RETRY_MAXTIMEOUT=5000
mkdir -p "$2"
cp "$1"/*.mjs "$1"/package.json "$2"
if ! cmp -s "$1/package-lock.json" "$2/node_modules/installed.json"; then
  cp "$1/package-lock.json" "$2"
  (cd "$2" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error) || {
    npm ping --loglevel=error >/dev/null 2>&1 && exit 1
    echo "SKIPPED: npm's registry cannot be reached, so the packages of $1 are missing"
    exit 77
  }
  cp "$1/package-lock.json" "$2/node_modules/installed.json"
fi
cd "$2"
exec node --test "$3"
