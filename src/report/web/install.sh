#!/bin/sh
# Installs the page's packages into the current folder, exactly those of package-lock.json: install.sh NPM
"$1" ci --ignore-scripts --no-audit --no-fund --loglevel=error && exit 0
echo "error: npm could not install three.js and esbuild for the comparison page (see above). Without access to a" >&2
echo "package registry build without the page: cmake --preset release -DLSMVS_BUILD_REPORT_PAGE=OFF" >&2
exit 1
