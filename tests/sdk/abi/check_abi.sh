#!/usr/bin/env bash
# Compares the interface of the headers with the recorded one of the revision, and proves that a
# change would be seen.
#
# usage: check_abi.sh [--record] SOURCE_DIRECTORY COMPILER
set -euo pipefail
record=
if [[ $1 == --record ]]; then record=yes && shift; fi
source=$1 compiler=$2
here=$source/tests/sdk/abi
revision=$(sed -n 's/^#define SOMAS_ABI_REVISION //p' "$source/sdk/include/somas/sdk/abi.hpp")
recorded=$here/revision$revision.abi
scratch=$(mktemp -d "${TMPDIR:-/tmp}/somas-abi.XXXXXX")
trap 'rm -rf "$scratch"' EXIT
command -v abidiff >/dev/null || { echo 'abidiff is missing: install abigail-tools'; exit 1; }

# The probe, built from the copy of the headers in $scratch/include; always for the same machine.
build_probe() {
  (cd "$scratch" && "$compiler" -std=c++20 -g -O0 -fPIC -shared -femit-class-debug-always \
    -I include -o "$1" probe.cpp)
}
# No type may be forgotten; these are of the plugin's own side only.
for type in $(sed -nE 's/^(enum class|struct|class) (\w+)( .*)?[:{].*/\2/p' "$source"/sdk/include/somas/sdk/*.hpp); do
  [[ $type =~ ^(About|Describe|Limits|NamedChoice|SinCos)$ ]] || grep -q "somas::$type\b" "$here/probe.cpp" ||
    { echo "probe.cpp does not export somas::$type"; exit 1; }
done

cp -r "$source/sdk/include" "$scratch/include"
cp "$here/probe.cpp" "$scratch/"
build_probe probe.so

if [[ $record ]]; then
  abidw --headers-dir "$scratch/include" --drop-private-types --no-corpus-path --no-comp-dir-path \
    --no-show-locs --out-file "$recorded" "$scratch/probe.so"
  echo "recorded $recorded"
  exit
fi
[[ -s $recorded ]] || { echo "revision $revision has no record: run $0 --record"; exit 1; }
[[ $(uname -m) == x86_64 ]] || { echo 'the record is for x86-64'; exit 77; }

differences() { abidiff "$recorded" "$1"; }
if ! differences "$scratch/probe.so" >"$scratch/difference"; then
  cat "$scratch/difference"
  echo "the interface is no longer that of revision $revision: extend it by extension(), or raise"
  echo 'SOMAS_ABI_REVISION, which refuses every plugin that is built'
  exit 1
fi

# mutate NAME FILE SED_COMMAND PATTERN: the change must be seen, and PATTERN be named.
mutate() {
  local name=$1 file=$scratch/include/somas/sdk/$2 original
  original=$(cat "$file")
  sed -i "$3" "$file"
  [[ $(cat "$file") != "$original" ]] || { echo "$name: the header has not changed"; exit 1; }
  build_probe "$name.so"
  if differences "$scratch/$name.so" >"$scratch/difference"; then
    echo "$name: the change was not seen"
    exit 1
  fi
  grep -q "$4" "$scratch/difference" || { cat "$scratch/difference"; echo "$name: $4 is not named"; exit 1; }
  printf '%s\n' "$original" >"$file"
}
mutate a_new_virtual world.hpp \
  's/  \[\[nodiscard\]\] virtual std::uint64_t step() const = 0;/  virtual void added() {}\n&/' 'somas::World'
mutate a_field_more layout.hpp 's/  std::uint64_t key;     .*parent.*//; s/^struct Port {/&\n  int added;/' 'somas::Port'
mutate an_order environment.hpp \
  's/  virtual void declare(Declare& declare) = 0;//; s/  virtual void act(Phase phase, World& world) const = 0;/&\n  virtual void declare(Declare\& declare) = 0;/' 'somas::Environment'
echo "revision $revision: unchanged; three changes are seen"
