#!/usr/bin/env bash
# What somebody does who has an installation and nothing else: new, build, test, run, replay. The
# installation has been moved; the source tree is out of reach where the system lets us hide it, and
# nothing may mention it.
#
# usage: consume.sh KIND WORK_DIRECTORY SOURCE_DIRECTORY COMPILER
set -euo pipefail
kind=$1 work=$2 source=$3 compiler=$4

# Once more, with an empty file system over the source tree, in a name space of its own.
if [[ ! ${SOMAS_HIDDEN-} ]]; then
  copy=$(mktemp -d "${TMPDIR:-/tmp}/somas-consume.XXXXXX")
  trap 'rm -rf "$copy"' EXIT
  cp -a "$work/moved here" "$copy/moved here"
  cp "${BASH_SOURCE[0]}" "$copy/consume.sh"
  clean=(env -i PATH="$PATH" HOME="$copy" TMPDIR="$copy" LC_ALL=C CCACHE_DISABLE=1)
  if unshare --user --map-root-user --mount true 2>/dev/null; then
    "${clean[@]}" SOMAS_HIDDEN=yes unshare --user --map-root-user --mount bash -c \
      'mount -t tmpfs none "$1" && shift && exec bash "$@"' \
      - "$source" "$copy/consume.sh" "$kind" "$copy" "$source" "$compiler"
  else
    echo 'name spaces are not allowed here: the source tree stays visible'
    "${clean[@]}" SOMAS_HIDDEN=no bash "$copy/consume.sh" "$kind" "$copy" "$source" "$compiler"
  fi
  exit
fi
if [[ $SOMAS_HIDDEN == yes && -e $source/CMakeLists.txt ]]; then
  echo 'the source tree is not hidden'
  exit 1
fi

cd "$work"
prefix="$work/moved here"
host=$prefix/bin/somas-host
name=salt_marsh
"$host" new "$kind" "$name" "my $kind" >new.log
cd "my $kind"

cmake -S . -B build -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$compiler" \
  -DCMAKE_CXX_FLAGS='-Wall -Wextra -Werror' >configure.log
cmake --build build >build.log || { cat build.log; exit 1; }
ctest --test-dir build --output-on-failure >ctest.log || { cat ctest.log; exit 1; }
grep -q '100% tests passed, 0 tests failed out of 2' ctest.log || { cat ctest.log; exit 1; }

"$host" check "build/plugins/$name.somas.so" >check.log || { cat check.log; exit 1; }
if grep '^  \(warn\|skip\)' check.log; then echo 'a template is not quite sound'; exit 1; fi
"$host" describe "$name" --plugin-path build/plugins >describe.log
grep -q "^$name ($kind): " describe.log || { cat describe.log; exit 1; }
"$host" "$name.yaml" --set evolution.population=6 --generations 1 --out run --quiet
grep -q "example.$name" run/manifest.json || { echo 'the run did not use the plugin'; exit 1; }
"$host" replay run | tail -1 | grep -q '^reproduced: ' || { echo 'the replay differs'; exit 1; }

# Nothing that was installed, written or built knows where the sources were.
if grep -rlF -- "$source" "$prefix" .; then
  echo "these files name the source tree $source"
  exit 1
fi
echo "$kind: created, built, tested, checked and run against the moved installation"
