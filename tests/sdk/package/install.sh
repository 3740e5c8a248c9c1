#!/usr/bin/env bash
# Installs the build into a prefix and moves it to where the other tests of the package use it. The
# name has a space.
#
# usage: install.sh BUILD_DIRECTORY WORK_DIRECTORY
set -euo pipefail
build=$1 work=$2

rm -rf "$work"
mkdir -p "$work"
cmake --install "$build" --prefix "$work/first" --strip >"$work/install.log"
mv "$work/first" "$work/moved here"
prefix="$work/moved here"

for file in bin/somas-host include/somas/sdk/plugin.hpp include/somas/sdk/testing.hpp \
  lib/cmake/SomasSDK/SomasSDKConfig.cmake lib/cmake/SomasSDK/SomasSDKConfigVersion.cmake \
  lib/somas/plugins/nutrients.somas.so share/somas/experiments/exp1.yaml \
  share/somas/template/environment/my_plugin.hpp share/doc/somas/docs/plugins.md \
  share/doc/somas/docs/authors/first-plugin.md share/doc/somas/docs/reference/plugins/nutrients.md \
  share/doc/somas/LICENSE; do
  [[ -s $prefix/$file ]] || { echo "$file is not installed"; exit 1; }
done

# Every bundled plugin, and nothing of the tests.
diff <(cd "$build/plugins" && ls -- *.somas.so) <(cd "$prefix/lib/somas/plugins" && ls) ||
  { echo 'the installed plugins are not those of the build'; exit 1; }
