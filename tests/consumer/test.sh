#!/usr/bin/env bash
# Installs the build tree given, which is complete, into a new prefix inside it, builds the consumer project against that and
# runs it.
#   tests/consumer/test.sh BUILD_DIR
set -euo pipefail
source_dir=$(cd "$(dirname "$0")" && pwd)
build_dir=$(cd "$1" && pwd)
work=$build_dir/consumer_test
rm -rf "$work"
mkdir -p "$work"
cmake --install "$build_dir" --prefix "$work/prefix" >"$work/install.log" || { tail -n 5 "$work/install.log"; exit 1; }
test -x "$work/prefix/bin/lsmvs" && test -x "$work/prefix/bin/lsmvs-mesher"
"$work/prefix/bin/lsmvs" --version
cmake -S "$source_dir" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/configure.log" ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/build"
"$work/build/consumer" "$work/tetrahedron.ply"
rm -rf "$work"
