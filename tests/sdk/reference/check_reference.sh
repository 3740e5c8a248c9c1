#!/usr/bin/env bash
# Builds the reference of the SDK, which fails on whatever is not documented, and proves that it does.
#
# usage: check_reference.sh SDK_DIRECTORY
set -euo pipefail
sdk=$1
scratch=$(mktemp -d "${TMPDIR:-/tmp}/somas-reference.XXXXXX")
trap 'rm -rf "$scratch"' EXIT

"$sdk/build-reference.sh" "$scratch/built"
html=$scratch/built/html
grep -q 'The plugin SDK' "$html/index.html" || { echo 'the main page is missing'; exit 1; }

# Every header and every type of the interface has its page; implementation details have none.
(cd "$sdk/include" && find somas -name '*.hpp' -printf '%f\n') | while read -r header; do
  grep -q ">$header<" "$html/files.html" || { echo "$header has no page"; exit 1; }
done
sed -nE 's/^(struct|class) (\w+)( .*)?[:{].*/\2/p' "$sdk"/include/somas/sdk/*.hpp | while read -r type; do
  grep -q ">$type<" "$html/annotated.html" || { echo "$type has no page"; exit 1; }
done
if grep -q '>detail<' "$html/annotated.html"; then echo 'details are shown'; exit 1; fi

# mutate NAME HEADER SED_COMMAND: doxygen must refuse a copy with this change, and name it.
mutate() {
  local name=$1 header=$2 command=$3 copy=$scratch/copy
  rm -rf "$copy"
  mkdir "$copy"
  cp -r "$sdk/include" "$sdk/Doxyfile" "$sdk/reference.md" "$copy/"
  sed -i "$command" "$copy/include/somas/sdk/$header"
  if diff -rq "$sdk/include" "$copy/include" >/dev/null; then
    echo "$name: the header has not changed"
    exit 1
  fi
  if "$sdk/build-reference.sh" "$scratch/mutated" "$copy" >"$scratch/said" 2>&1; then
    echo "$name: not refused"
    exit 1
  fi
  grep -q "$name" "$scratch/said" || { cat "$scratch/said"; echo "$name is not named"; exit 1; }
}
mutate added_call world.hpp 's/^class World .*/&\n public:\n  virtual void added_call() = 0;/'
mutate added_member layout.hpp 's/^struct Port {/&\n  int added_member;/'
mutate AddedType fitness.hpp 's/^namespace somas {/&\nstruct AddedType { int x; };/'
mutate added_function rng.hpp 's/^namespace somas {/&\nvoid added_function();/'
mutate AddedWords world.hpp 's/^namespace somas {/&\nenum class AddedWords { one };/'
mutate no_such_type types.hpp 's/^namespace somas {/&\n\/\/\/ See #no_such_type.\nvoid f();/'
echo 'the reference is whole; six gaps are seen'
