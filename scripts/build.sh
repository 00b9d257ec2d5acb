#!/usr/bin/env bash
# Builds into build/<preset>/; the programs are in build/<preset>/bin/.
#   scripts/build.sh [release|dev|asan-ubsan|tsan] [further cmake options]
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:-release}
shift || true
# Without the tests' packages only the programs are built.
tests=ON
dpkg-query -W libgtest-dev libbenchmark-dev >/dev/null 2>&1 || tests=OFF
options=(-DLSMVS_BUILD_TESTS=$tests -DLSMVS_BUILD_BENCHMARKS=$tests)
# A compiler of this code takes up to 1.5 GB: as many jobs as memory and cores allow.
jobs=$(awk -v cores="$(nproc)" '/MemAvailable/ {n = int($2 / 1500000); print n < 1 ? 1 : (n < cores ? n : cores)}' /proc/meminfo)
cmake --preset "$preset" "${options[@]}" "$@"
cmake --build --preset "$preset" -j "$jobs"
