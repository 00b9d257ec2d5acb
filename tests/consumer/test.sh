#!/usr/bin/env bash
# Installs the build tree given into a new prefix, builds the consumer project against it and runs it.
#   tests/consumer/test.sh BUILD_DIR
set -euo pipefail
source_dir=$(cd "$(dirname "$0")" && pwd)
build_dir=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake --install "$build_dir" --prefix "$work/prefix" >"$work/install.log"
test -x "$work/prefix/bin/lsmvs" && test -x "$work/prefix/bin/lsmvs-mesher"
"$work/prefix/bin/lsmvs" --version
cmake -S "$source_dir" -B "$work/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix" >"$work/configure.log" ||
  { cat "$work/configure.log"; exit 1; }
cmake --build "$work/build"
"$work/build/consumer" "$work/tetrahedron.ply"
