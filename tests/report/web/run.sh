#!/bin/sh
# Makes the test page and looks at it in Chromium: run.sh NPM NODE CHROMIUM MAKE_TEST_PAGE BUILD_FOLDER
set -e
here=$(cd "$(dirname "$0")" && pwd)
npm=$1 node=$2 chromium=$3 maker=$4 folder=$5
mkdir -p "$folder"
if ! cmp -s "$here/package-lock.json" "$folder/package-lock.json" || [ ! -d "$folder/node_modules/playwright-core" ]; then
  cp "$here/package.json" "$folder"
  (cd "$folder" && cp "$here/package-lock.json" . && "$npm" ci --ignore-scripts --no-audit --no-fund --loglevel=error)
fi
"$maker" "$folder/page.html" 200000
exec "$node" "$here/page_test.mjs" "$chromium" "$folder/page.html" "$folder"
