#!/usr/bin/env bash
# The campaign of kills in a scratch directory.
#
# usage: tests/faults/faults.sh BUILD_DIRECTORY EXPERIMENT.yaml [--kills N] [--seed N]
set -euo pipefail
build=$1 experiment=$2
shift 2
scratch=$(mktemp -d "${TMPDIR:-/tmp}/somas-faults.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
launcher=()
if [[ -e $build/lib/somas/somas_mpi.so ]] && command -v mpirun >/dev/null; then
  words='mpirun --oversubscribe --bind-to none --mca plm isolated'
  words+=' --mca btl_vader_single_copy_mechanism none'
  ((EUID != 0)) || words+=' --allow-run-as-root'
  launcher=(--launcher "$words")
fi
"$build/bin/faults" "$build/bin/somas-host" "$scratch" "${launcher[@]}" "$@" -- "$experiment"
