#!/usr/bin/env bash
# A plugin exports its entry and nothing else.
#
# usage: check_symbols.sh DIRECTORY...
set -euo pipefail
count=0 failed=0
for directory in "$@"; do
  for library in "$directory"/*.somas.so; do
    count=$((count + 1))
    exported=$(nm --dynamic --defined-only --format=posix "$library" | cut -d' ' -f1)
    [[ $exported == somas_plugin ]] || { echo "$library exports:" $exported; failed=1; }
  done
done
echo "$count plugins"
((count > 10 && failed == 0))
