#!/usr/bin/env bash
# Formats all C++ files; with --check only says which ones would change.
set -euo pipefail
cd "$(dirname "$0")/.."
mode=(-i)
[ "${1:-}" = --check ] && mode=(--dry-run --Werror)
git ls-files -z '*.h' '*.cc' | xargs -0 -r clang-format "${mode[@]}"
