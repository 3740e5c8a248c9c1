#!/usr/bin/env bash
# A project that asks for another version of the SDK is told so; one without C++, too.
#
# usage: version.sh WORK_DIRECTORY
set -euo pipefail
prefix="$1/moved here"
scratch=$(mktemp -d "${TMPDIR:-/tmp}/somas-version.XXXXXX")
trap 'rm -rf "$scratch"' EXIT

# configure LANGUAGES VERSION: into $scratch/log
configure() {
  printf 'cmake_minimum_required(VERSION 3.25)\nproject(p LANGUAGES %s)\nfind_package(SomasSDK %s REQUIRED)\n' \
    "$1" "$2" >"$scratch/CMakeLists.txt"
  rm -rf "$scratch/build"
  cmake -S "$scratch" -B "$scratch/build" -DCMAKE_PREFIX_PATH="$prefix" >"$scratch/log" 2>&1
}

configure CXX 0.1 || { cat "$scratch/log"; echo 'version 0.1 is refused'; exit 1; }
for version in 0.2 1.0 0.0; do
  if configure CXX "$version"; then echo "version $version is accepted"; exit 1; fi
  tr -s ' \n' ' ' <"$scratch/log" | grep -q "compatible with requested version \"$version\"" ||
    { cat "$scratch/log"; exit 1; }
done
if configure C 0.1; then echo 'a project in C is accepted'; exit 1; fi
grep -q 'SomasSDK is for C++' "$scratch/log" || { cat "$scratch/log"; exit 1; }
