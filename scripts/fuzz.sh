#!/usr/bin/env bash
# Builds the fuzzers of the readers (with clang) and runs each.
#   scripts/fuzz.sh [seconds for each, default 60] [names, e.g. cameras ply; default: all]
# Findings are written to build/fuzz/findings/<name>/ and make the script fail.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true

cmake --preset fuzz > /dev/null
cmake --build build/fuzz --target fuzzers
work=$PWD/build/fuzz
"$work/fuzz/make_seeds" "$work/seeds"

names=("$@")
if [ ${#names[@]} -eq 0 ]; then
  for program in "$work"/fuzz/fuzz_*; do names+=("${program##*/fuzz_}"); done
fi
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1:halt_on_error=1}
failed=()
for name in "${names[@]}"; do
  mkdir -p "$work/corpus/$name" "$work/seeds/$name" "$work/findings/$name"
  echo "== $name: $seconds s"
  # A file of 64 KiB may not take more than 512 MiB or 10 s.
  "$work/fuzz/fuzz_$name" -max_total_time="$seconds" -max_len=65536 -timeout=10 -rss_limit_mb=1024 \
    -malloc_limit_mb=512 -print_final_stats=0 -verbosity=0 -artifact_prefix="$work/findings/$name/" \
    "$work/corpus/$name" "$work/seeds/$name" || failed+=("$name")
  echo "   $(find "$work/corpus/$name" -type f | wc -l) inputs in the corpus"
done
if [ ${#failed[@]} -gt 0 ]; then
  echo "error: findings in ${failed[*]}; see build/fuzz/findings/" >&2
  exit 1
fi
echo "no findings"
