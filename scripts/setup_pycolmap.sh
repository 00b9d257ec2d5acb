#!/usr/bin/env bash
# Installs the current COLMAP as the Python package pycolmap into build/pycolmap-venv, for the tests that try our files on
# it and its files on us. Nothing else needs it; without it those tests are skipped and say so.
set -euo pipefail
cd "$(dirname "$0")/.."
venv=build/pycolmap-venv
[ -x "$venv/bin/python" ] && "$venv/bin/python" -c 'import pycolmap' 2>/dev/null && exit 0

mkdir -p build
rm -rf "$venv"
/usr/bin/python3 -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check pycolmap
"$venv/bin/python" -c 'import pycolmap; print("pycolmap", pycolmap.__version__, "is in build/pycolmap-venv")'
