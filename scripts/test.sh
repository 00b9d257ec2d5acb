#!/usr/bin/env bash
# Installs what is missing, builds and runs all tests.
#   scripts/test.sh [release|dev|asan-ubsan|tsan] [further ctest options]
# Tests that need the scene data say so and are skipped where they are not there (see tests/README.md).
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift || true
scripts/setup.sh --test
scripts/setup_pycolmap.sh || echo "note: no pycolmap; the tests that need it are skipped" >&2
scripts/build.sh "$preset"
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:allocator_may_return_null=0}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
export TSAN_OPTIONS=${TSAN_OPTIONS:-suppressions=$PWD/tests/support/tsan.supp}
cd "build/$preset"
exec ctest --output-on-failure -j "$(nproc)" "$@"
