#!/usr/bin/env bash
# Runs a campaign and tells, as Markdown, what evolved: survival in the first and last generation of
# each run, and the anatomy of its last champion. A campaign that is there is gone on with.
#
#   experiments/campaign.sh EXPERIMENT.yaml [--replicates N] [--out DIR] [OPTIONS of somas-host run]
set -euo pipefail

usage() {
  echo 'usage: campaign.sh EXPERIMENT.yaml [--replicates N] [--out DIR] [OPTIONS of somas-host run]' >&2
  exit 2
}

(($#)) || usage
experiment=$1
shift
[[ -f $experiment ]] || { echo "campaign: no such experiment: $experiment" >&2; exit 2; }
replicates=3 out=campaign options=()
while (($#)); do
  case $1 in
    --replicates) [[ ${2-} =~ ^[0-9]+$ ]] && ((10#$2 > 1)) || usage; replicates=$2; shift 2 ;;
    --out) [[ -n ${2-} ]] || usage; out=$2; shift 2 ;;
    *) options+=("$1"); shift ;;
  esac
done
host=${SOMAS_HOST:-somas-host}

if [[ -e $out/campaign.json ]]; then
  "$host" resume "$out" --replicates "$replicates" >&2
else
  "$host" run "$experiment" --replicates "$replicates" --out "$out" "${options[@]}" >&2
fi

# Columns of generations.csv by name, so that new columns do no harm.
column() { awk -F, -v row="$2" -v name="$3" '
  NR == 1 { for (i = 1; i <= NF; ++i) if ($i == name) wanted = i }
  row == "first" && NR == 2 { print $wanted }
  { last = $wanted }
  END { if (row == "last") print last }' "$1/generations.csv"; }

# Condition, seed and directory of each run.
runs() { tail -n +2 "$out/index.csv" | cut -d, -f2,4,6; }

echo "| condition | seed | generations | best, first | median, first | best, last | median, last | best, ratio |"
echo "|---|---|---|---|---|---|---|---|"
while IFS=, read -r condition seed directory; do
  run=$out/$directory
  first=$(column "$run" first best) last=$(column "$run" last best)
  echo "| $condition | $seed | $(($(column "$run" last generation) + 1)) | $first |" \
    "$(column "$run" first median) | $last | $(column "$run" last median) |" \
    "$(awk "BEGIN { printf \"%.2f\", $last / $first }") |"
done < <(runs)
while IFS=, read -r condition seed directory; do
  run=$out/$directory
  printf '\n%s, seed %s, last champion:\n\n```\n' "$condition" "$seed"
  "$host" replay "$run" --anatomy --anatomy-csv "$run/anatomy.csv"
  echo '```'
done < <(runs)
