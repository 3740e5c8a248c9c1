#!/usr/bin/env bash
# Includes point downward only:
#
#   host > report > run > recording > evaluation > experiment > evolution > plugins > model > sdk
#
# and conformance beside evaluation.
#
# usage: cmake/check-layers.sh [ROOT]. Prints each offending file:line; exits with 1 if any.
set -euo pipefail
cd "${1:-$(dirname "${BASH_SOURCE[0]}")/..}"

# file:line:header for every #include below the given folders; the header keeps its <> or "".
includes() {
  local folders=()
  for folder in "$@"; do [[ ! -d $folder ]] || folders+=("$folder"); done
  ((${#folders[@]})) || return 0
  grep -rnE --include='*.hpp' --include='*.h' --include='*.cpp' --include='*.inl' \
    '^[[:space:]]*#[[:space:]]*include' "${folders[@]}" |
    sed -E 's/^([^:]*:[0-9]+:)[^<"]*([<"][^>"]*[>"]).*/\1\2/' || true
}

{
  includes core | awk '
    BEGIN {
      rank["host"] = 9; rank["report"] = 8; rank["run"] = 7; rank["recording"] = 6; rank["evaluation"] = 5
      rank["conformance"] = 5
      rank["evolution"] = 3; rank["experiment"] = 4; rank["plugins"] = 2; rank["model"] = 1
    }
    function complain(text) { print place ": " text " (" header ")" }
    {
      split($0, part, ":"); place = part[1] ":" part[2]
      header = substr($0, length(place) + 2)
      split(part[1], path, "/"); room = path[2]
      name = substr(header, 2, length(header) - 2); split(name, step, "/"); target = step[2]

      if (!(room in rank)) complain("core/" room " is not a room of cmake/check-layers.sh")
      else if (name ~ /(^|\/)\.\.(\/|$)/) complain("spell includes from the root of the repository")
      else if (name ~ /^(plugins|tests|bench)\//) complain("core must not know " step[1] "/")
      else if (name !~ /^core\//) next
      else if (!(target in rank)) complain("core/" target " is not a room of cmake/check-layers.sh")
      else if (target != room && rank[target] >= rank[room])
        complain("core/" room " must not include core/" target)
    }'

  # A bundled plugin sees what any plugin sees.
  includes plugins | grep -E ':[<"](core|tests)/' | sed 's/$/: a plugin includes the SDK only/' || true

  # The SDK needs the standard library only.
  includes sdk/include |
    grep -vE ':<([a-z0-9_]+|stdbool\.h|stddef\.h|stdint\.h)>$|:"somas/sdk/[^"]*"$' |
    sed 's/$/: the SDK includes the standard library and somas\/sdk only/' || true
} | { if grep . ; then echo 'check-layers: failed'; exit 1; else echo 'check-layers: ok'; fi; }
