#!/usr/bin/env bash
# The SDK needs nothing but the standard library: no file that its headers pull in comes from
# elsewhere, and every header is among them. (That each compiles alone is test_sdk_headers.)
#
# usage: check_headers.sh INCLUDE_DIRECTORY COMPILER
set -euo pipefail
include=$(cd "$1" && pwd -P) compiler=$2

# The compiler's own directories, and the C library's top level with its folders.
machine=$("$compiler" -dumpmachine)
allowed="^(/usr/include/c\+\+|/usr/lib/(gcc|llvm-)[^ ]*|/usr/include/($machine|x86_64-linux-gnu|aarch64-linux-gnu)/(c\+\+|bits|gnu|sys|asm)|/usr/include/(asm-generic|linux))/|^/usr/include/[a-z0-9-]+\.h$"

dependencies=$(printf '#include <somas/sdk/plugin.hpp>\n#include <somas/sdk/testing.hpp>\n' |
  "$compiler" -std=c++20 -M -I "$include" -x c++ - | tr -d '\\' | tr ' ' '\n' |
  sed '/^$/d; /:$/d; /^-$/d' | xargs realpath -m)
if grep -vF "$include/" <<<"$dependencies" | grep -vE "$allowed"; then
  echo 'the SDK pulls in these files, which are not of the standard library'
  exit 1
fi
diff <(grep -F "$include/" <<<"$dependencies" | sort -u) <(find "$include" -name '*.hpp' | sort) ||
  { echo 'these headers are not among those that plugin.hpp and testing.hpp include'; exit 1; }
echo "$(grep -cF "$include/" <<<"$dependencies") headers"
