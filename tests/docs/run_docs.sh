#!/usr/bin/env bash
# Runs the shell blocks of a page of documentation and compares what they print with what the page
# shows.
#
# usage: tests/docs/run_docs.sh [--update] BUILD_DIRECTORY PAGE
#
# Blocks run in order in a scratch directory that holds experiments/ and docs/examples/, and the build directory as
# build/release, with somas-host on the PATH. As in a reader's terminal, the current directory and the
# PATH that a block leaves are those of the next. Comments before a block, invisible to readers, say more:
#
#   <!-- test: skip REASON -->  the shell block is not run
#   <!-- test: exit N -->       it ends with exit code N; standard error counts as output
#   <!-- output -->             the block is the standard output of the shell block before it
#   <!-- file: NAME -->         the block is written to the file NAME
#   <!-- edit: NAME -->         the block is an edit of the file NAME (see apply_edit.py)
#
# --update writes what was printed into the page instead of comparing. With SOMAS_DOCS_TIMES=1 the time that
# each block takes is told on the standard error.
set -euo pipefail

update=
if [[ ${1-} == --update ]]; then
  update=yes
  shift
fi
(($# == 2)) || { echo "usage: $0 [--update] BUILD_DIRECTORY PAGE" >&2; exit 2; }
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd -P)
tools=$root/tests/docs
build=$(cd "$1" && pwd -P)
page=$root/$2
[[ -x $build/bin/somas-host ]] || { echo "$build/bin/somas-host was not built" >&2; exit 2; }

scratch=$(mktemp -d "${TMPDIR:-/tmp}/somas-docs.XXXXXX")
scratch=$(cd "$scratch" && pwd -P)
trap 'rm -rf "$scratch"' EXIT
work=$scratch/work
mkdir -p "$work/build"
cp -r "$root/experiments" "$work/"
mkdir "$work/docs"
cp -r "$root/docs/examples" "$work/docs/"
ln -s "$build" "$work/build/release"
unset SOMAS_PLUGIN_PATH

failures=0
ran=0
line_number=0
fail() {
  echo "$2:$line_number: $1"
  failures=$((failures + 1))
}

# Paths of this machine, as the page shows them.
portable() { sed -e "s|$build|build/release|g" -e "s|$work/||g" -e "s|$work|.|g"; }

# Where the next block begins, and how a block leaves it.
here=$work
search=$build/bin:/usr/bin:$PATH
keep='trap '"'"'printf "%s\n%s\n" "$PWD" "$PATH" >"$0"'"'"' EXIT
'
run_block() {
  local code=0
  local begin=$EPOCHREALTIME
  (cd "$here" && PATH=$search bash -euo pipefail -c "$keep$block" "$scratch/left") \
    >"$scratch/out" 2>"$scratch/err" </dev/null || code=$?
  { read -r here && read -r search; } <"$scratch/left"
  [[ ! ${SOMAS_DOCS_TIMES-} ]] ||
    echo "$2:$line_number: $(((${EPOCHREALTIME/./} - ${begin/./}) / 1000)) ms" >&2
  ran=$((ran + 1))
  if ((expected_code != 0)); then cat "$scratch/err" >>"$scratch/out"; fi
  portable <"$scratch/out" >"$scratch/printed"
  if ((code != expected_code)); then
    fail "exit code $code instead of $expected_code" "$2"
    sed 's/^/  | /' "$scratch/printed" "$scratch/err"
  fi
}

directive='' argument='' language='' block='' expected_code=0
: >"$scratch/printed"
: >"$scratch/page"
inside=
while IFS= read -r line || [[ $line ]]; do
  line_number=$((line_number + 1))
  if [[ ! $inside ]]; then
    printf '%s\n' "$line" >>"$scratch/page"
    if [[ $line =~ ^'<!-- '(test: skip|test: exit|output|file:|edit:)' '?(.*)' -->'$ ]]; then
      directive=${BASH_REMATCH[1]} argument=${BASH_REMATCH[2]}
    elif [[ $line == '<!-- test:'* || $line == '<!-- output'* || $line == '<!-- file:'* ||
      $line == '<!-- edit:'* ]]; then
      fail "not understood: $line" "$2"
    elif [[ $line == '```'* ]]; then
      inside=yes language=${line#'```'} block=
    elif [[ $line ]]; then
      directive='' argument=''
    fi
    continue
  fi
  if [[ $line != '```' ]]; then
    block+=$line$'\n'
    continue
  fi

  inside=
  if [[ $directive == output ]]; then
    if [[ $update ]]; then
      block=$(cat "$scratch/printed")$'\n'
    elif ! printf '%s' "$block" | diff - "$scratch/printed" >"$scratch/difference"; then
      fail 'the output differs (<: the page, >: printed)' "$2"
      cat "$scratch/difference"
    fi
  elif [[ $directive == file: ]]; then
    mkdir -p "$(dirname "$here/$argument")"
    printf '%s' "$block" >"$here/$argument"
  elif [[ $directive == edit: ]]; then
    printf '%s' "$block" | "$tools/apply_edit.py" "$here/$argument" || fail 'this edit fails' "$2"
  elif [[ $language == sh && $directive != 'test: skip' ]]; then
    expected_code=0
    [[ $directive != 'test: exit' ]] || expected_code=$argument
    run_block "$1" "$2"
  fi
  printf '%s%s\n' "$block" "$line" >>"$scratch/page"
  directive='' argument=''
done <"$page"

[[ ! $inside ]] || fail 'a block has no end' "$2"
if [[ $update ]] && ((failures == 0)); then cat "$scratch/page" >"$page"; fi
echo "$2: $ran blocks run, $failures failures"
((failures == 0))
