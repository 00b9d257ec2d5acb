#!/usr/bin/env bash
# Runs clang-tidy (.clang-tidy) and fails on any finding. Needs a configured build: scripts/build.sh release.
#   scripts/tidy.sh          files changed in the last commit and since: what CI runs, the first 20 of them
#   scripts/tidy.sh BASE     files changed since BASE
#   scripts/tidy.sh --all    every file; an hour of CPU
set -euo pipefail
cd "$(dirname "$0")/.."
build=build/release
[ -f $build/compile_commands.json ] || { echo "error: $build is not configured; run scripts/build.sh release" >&2; exit 2; }

base=${1:-HEAD~1}
if [ "$base" = --all ]; then
  changed=$(git ls-files '*.cc')
elif git rev-parse -q --verify "$base^{commit}" >/dev/null; then
  changed=$(git diff --name-only --diff-filter=d "$base" -- '*.cc' '*.h')
else
  echo "tidy: there is no commit $base to compare with; nothing checked"
  exit 0
fi

# A header is checked with the source file of its name.
files=()
for file in $changed; do
  source=${file%.*}.cc
  [ -f "$source" ] && grep -q "/$source\"" $build/compile_commands.json && files+=("$source")
done
mapfile -t files < <(printf '%s\n' "${files[@]:-}" | sed '/^$/d' | sort -u)
[ $# -gt 0 ] || files=("${files[@]:0:20}")
echo "tidy: ${#files[@]} file(s)"
[ ${#files[@]} -eq 0 ] && exit 0
printf '%s\0' "${files[@]}" | xargs -0 -n 1 -P "$(nproc)" clang-tidy -p $build --quiet --warnings-as-errors='*'
