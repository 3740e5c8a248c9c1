#!/usr/bin/env bash
# The core must not know its plugins: no id of a bundled plugin stands in core/ as a string.
# The ids are read from the plugins' own `static constexpr somas::About about{"ID", "doc"};`.
#
# usage: cmake/check-names.sh [ROOT]. Prints each offending file:line; exits with 1 if any.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}"

sources=()
if [[ -d plugins ]]; then
  while IFS= read -r -d '' file; do sources+=("$file"); done \
    < <(find plugins -type f \( -name '*.cpp' -o -name '*.hpp' \) -print0)
fi
if ((${#sources[@]} == 0)); then
  echo 'check-names: no bundled plugins, nothing to check'
  exit 0
fi

# -z: a declaration may span lines.
mapfile -t ids < <(
  grep -hozP '\bAbout\s+\w+\s*(=\s*)?\{\s*(\.id\s*=\s*)?"\K[^"]+(?=")' "${sources[@]}" |
    tr '\0' '\n' | sort -u)
if ((${#ids[@]} == 0)); then
  echo 'check-names: plugins/ has sources, but no About about{"ID", ...} was found in them'
  exit 1
fi

patterns=()
for id in "${ids[@]}"; do patterns+=(-e "\"$id\""); done
if grep -rnF "${patterns[@]}" core --include='*.cpp' --include='*.hpp' --include='*.h' \
  --include='*.inl'; then
  echo "check-names: core/ names a bundled plugin"
  exit 1
fi
echo "check-names: ok (${#ids[@]} ids)"
