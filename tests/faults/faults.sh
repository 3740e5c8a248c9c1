#!/usr/bin/env bash
# The campaign of kills in a scratch directory.
#
# usage: tests/faults/faults.sh BUILD_DIRECTORY EXPERIMENT.yaml [--kills N] [--seed N]
set -euo pipefail
build=$1 experiment=$2
shift 2
scratch=$(mktemp -d "${TMPDIR:-/tmp}/somas-faults.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
"$build/bin/faults" "$build/bin/somas-host" "$scratch" "$@" -- "$experiment"
