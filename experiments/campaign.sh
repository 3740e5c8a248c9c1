#!/usr/bin/env bash
# Runs an experiment on several seeds and tells, as Markdown, what evolved: survival in the first and
# last generation, and the anatomy of each last champion. Run directories that exist are not run again.
#
#   experiments/campaign.sh EXPERIMENT.yaml --seeds "1 2 3" [--out DIR] [OPTIONS of somas-host run]
set -euo pipefail

usage() {
  echo 'usage: campaign.sh EXPERIMENT.yaml [--seeds "1 2 3"] [--out DIR] [OPTIONS of somas-host run]' >&2
  exit 2
}

(($#)) || usage
experiment=$1
shift
[[ -f $experiment ]] || { echo "campaign: no such experiment: $experiment" >&2; exit 2; }
seeds="1 2 3" out=campaign options=()
while (($#)); do
  case $1 in
    --seeds) [[ ${2-} =~ ^[0-9]+(\ [0-9]+)*$ ]] || usage; seeds=$2; shift 2 ;;
    --out) [[ -n ${2-} ]] || usage; out=$2; shift 2 ;;
    *) options+=("$1"); shift ;;
  esac
done
host=${SOMAS_HOST:-somas-host}
name=$(basename "$experiment" .yaml)
mkdir -p "$out"

# Columns of generations.csv by name, so that new columns do no harm.
column() { awk -F, -v row="$2" -v name="$3" '
  NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) wanted = i }
  row == "first" && NR == 2 { print $wanted }
  { last = $wanted }
  END { if (row == "last") print last }' "$1/generations.csv"; }

for seed in $seeds; do
  run=$out/$name-seed$seed
  [[ -f $run/summary.json ]] || "$host" run "$experiment" --seed "$seed" --out "$run" "${options[@]}" >&2
done

echo "| seed | generations | best, first | median, first | best, last | median, last | best, ratio |"
echo "|---|---|---|---|---|---|---|"
for seed in $seeds; do
  run=$out/$name-seed$seed
  first=$(column "$run" first best) last=$(column "$run" last best)
  echo "| $seed | $(($(column "$run" last generation) + 1)) | $first | $(column "$run" first median) |" \
    "$last | $(column "$run" last median) | $(awk "BEGIN { printf \"%.2f\", $last / $first }") |"
done
for seed in $seeds; do
  run=$out/$name-seed$seed
  printf '\nSeed %s, last champion:\n\n```\n' "$seed"
  "$host" replay "$run" --anatomy --anatomy-csv "$run/anatomy.csv"
  echo '```'
done
