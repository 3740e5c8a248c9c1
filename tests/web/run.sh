#!/usr/bin/env bash
# Tests of the replay page.
#
# usage: tests/web/run.sh lint|unit|build|browser BUILD_DIRECTORY
#
# Ends with 77, skipped, where there is no node or no web/node_modules (`./dev deps web`), unless
# SOMAS_WEB_TESTS=required.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
part=$1
build=$(cd "$2" && pwd -P)
cd "$root/web"

skip() {
  echo "$1"
  [[ ${SOMAS_WEB_TESTS-} != required ]] || exit 1
  exit 77
}
command -v node >/dev/null || skip 'there is no node'
[[ -d node_modules ]] || skip 'there is no web/node_modules: run ./dev deps web'
export PATH="$PWD/node_modules/.bin:$PATH"

case $part in
  lint)
    tsc --noEmit
    eslint .
    ;;
  unit) vitest run ;;
  build)
    # What is committed is what the sources make.
    made=$(mktemp -d "${TMPDIR:-/tmp}/somas-web.XXXXXX")
    trap 'rm -rf "$made"' EXIT
    SOMAS_WEB_OUT=$made vite build
    cmp "$made/replay.html" dist/replay.html ||
      { echo 'web/dist/replay.html is not what web/src makes: run ./dev web, and commit it'; exit 1; }
    ;;
  browser)
    [[ -x /usr/bin/chromium ]] || skip 'there is no /usr/bin/chromium'
    export SOMAS_HOST=$build/bin/somas-host SOMAS_EXPERIMENTS=$root/experiments
    export SOMAS_SCREENSHOTS=$build/tests/web/screenshots
    rm -rf "$SOMAS_SCREENSHOTS"
    mkdir -p "$SOMAS_SCREENSHOTS"
    vitest run --config vitest.browser.config.ts
    ;;
  *)
    echo "no such part: $part"
    exit 2
    ;;
esac
