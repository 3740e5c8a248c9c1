#!/usr/bin/env bash
# Compares two builds of the benchmarks on a machine that others use, too: they run in turn, and of
# each benchmark the least times and the middle one of the ratios of neighbouring runs are told.
#
# usage: bench/compare.sh OLD NEW [--rounds N] [ARGUMENTS OF THE BENCHMARKS]
#
# OLD and NEW are build directories, or their bench/bench_somas.
set -euo pipefail

usage() { sed -n 's/^# usage: //p' "${BASH_SOURCE[0]}" >&2; exit 2; }
(($# >= 2)) || usage

program_of() {
  local program=$1
  [[ ! -d $program ]] || program=$program/bench/bench_somas
  [[ -f $program && -x $program ]] || { echo "compare: no benchmarks: $1" >&2; exit 2; }
  realpath "$program"
}
old=$(program_of "$1")
new=$(program_of "$2")
shift 2
rounds=7
if [[ ${1-} == --rounds ]]; then
  [[ ${2-} =~ ^[1-9][0-9]*$ ]] || usage
  rounds=$2
  shift 2
fi

results=$(mktemp "${TMPDIR:-/tmp}/somas-bench.XXXXXX")
trap 'rm -f "$results"' EXIT
for ((round = 1; round <= rounds; ++round)); do
  for version in old new; do
    "${!version}" --benchmark_min_time=0.05 "$@" --benchmark_format=json 2>/dev/null |
      awk -F'": |,$' -v tag="$round $version" '
        { value = $2; gsub(/"|\/process_time/, "", value) }
        /^ *"name": / { name = value }
        /^ *"cpu_time": / { time = value }
        /^ *"time_unit": / { print tag, name, time, value }' >>"$results"
  done
done

awk '
  { time[$3, $2, $1] = $4; unit[$3] = $5
    if (!(($3, $2) in least) || $4 < least[$3, $2]) least[$3, $2] = $4
    if (!($3 in seen)) { seen[$3] = 1; names[++count] = $3 }
    if ($1 > rounds) rounds = $1 }
  END {
    printf "%-44s %12s %12s %9s %9s\n", "benchmark (CPU time)", "old, least", "new, least",
           "new/old", "median"
    for (n = 1; n <= count; ++n) {
      name = names[n]; found = 0
      if (!((name, "old") in least) || !((name, "new") in least)) {
        printf "%-44s in one of them only\n", name
        continue
      }
      for (r = 1; r <= rounds; ++r) {
        ratio = time[name, "new", r] / time[name, "old", r]
        for (i = ++found; i > 1 && sorted[i - 1] > ratio; --i) sorted[i] = sorted[i - 1]
        sorted[i] = ratio
      }
      printf "%-44s %9.5g %-2s %9.5g %-2s %9.3f %9.3f\n", name, least[name, "old"], unit[name],
             least[name, "new"], unit[name], least[name, "new"] / least[name, "old"],
             sorted[int((found + 1) / 2)]
    }
  }' "$results"
