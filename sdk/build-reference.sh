#!/usr/bin/env bash
# Builds the reference of the SDK, HTML from the comments of the headers, into OUTPUT_DIRECTORY/html.
# Needs doxygen and no network. Whatever is not documented, or documented wrongly, is an error.
#
# usage: build-reference.sh OUTPUT_DIRECTORY [SDK_DIRECTORY]
set -euo pipefail
mkdir -p "$1"
output=$(cd "$1" && pwd -P)
cd "${2:-$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")}"
command -v doxygen >/dev/null || { echo 'doxygen is missing: ./dev deps docs' >&2; exit 1; }
SOMAS_REFERENCE=$output doxygen Doxyfile
echo "$output/html/index.html"
