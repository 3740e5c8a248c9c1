#!/usr/bin/env bash
# The first page of the guide for plugin authors, followed to the letter by somebody who has an
# installation and nothing else: the page is the installed one, the installation has been moved, and the
# source tree is out of reach where the system lets us hide it.
#
# usage: tutorial.sh WORK_DIRECTORY SOURCE_DIRECTORY
set -euo pipefail
work=$1 source=$2
copy=$(mktemp -d "${TMPDIR:-/tmp}/somas-tutorial.XXXXXX")
trap 'rm -rf "$copy"' EXIT

cp -a "$work/moved here" "$copy/moved here"
prefix="$copy/moved here"
mkdir -p "$copy"/{tests/docs,docs/authors,docs/examples,experiments,build/bin}
cp "$source/tests/docs/run_docs.sh" "$source/tests/docs/apply_edit.py" "$copy/tests/docs/"
cp "$prefix/share/doc/somas/docs/authors/first-plugin.md" "$copy/docs/authors/"

# What the page calls the build is the installation: to install it is to copy it.
ln -s "$prefix/bin/somas-host" "$copy/build/bin/somas-host"
# shellcheck disable=SC2016
printf 'file(COPY "%s/" DESTINATION "${CMAKE_INSTALL_PREFIX}")\n' "$prefix" \
  >"$copy/build/cmake_install.cmake"

follow=("$copy/tests/docs/run_docs.sh" "$copy/build" docs/authors/first-plugin.md)
clean=(env -i PATH="$PATH" HOME="$copy" TMPDIR="$copy" LC_ALL=C CCACHE_DISABLE=1)
cd "$copy"  # where we are may be about to be hidden
begin=$SECONDS
if unshare --user --map-root-user --mount true 2>/dev/null; then
  # shellcheck disable=SC2016
  "${clean[@]}" unshare --user --map-root-user --mount bash -euc \
    'mount -t tmpfs none "$0" && [[ ! -e $0/CMakeLists.txt ]] && exec "$@"' "$source" "${follow[@]}"
else
  echo 'name spaces are not allowed here: the source tree stays visible'
  "${clean[@]}" "${follow[@]}"
fi
echo "from an empty directory to a plugin that runs: $((SECONDS - begin)) s"
