#!/usr/bin/env bash
# Builds lsmvs on another release of Debian, in a root folder of its own, makes the package, installs that in a bare root
# and reconstructs a rendered scene there; then runs all tests in the first root. Run by hand, as root, with debootstrap
# installed; an hour or two on 2 cores, 10 GB of disk.
#   scripts/check_distribution.sh trixie            in /var/tmp/lsmvs-trixie, which is kept: a second run goes faster
#   scripts/check_distribution.sh bookworm FOLDER
#   JOBS=1 scripts/check_distribution.sh trixie      compilers and tests at once; every core without it
set -euo pipefail
cd "$(dirname "$0")/.."
suite=${1:?usage: scripts/check_distribution.sh SUITE [FOLDER]}
folder=${2:-/var/tmp/lsmvs-$suite}
jobs=${JOBS:-$(nproc)}
command -v debootstrap >/dev/null || { echo "error: debootstrap is missing; apt-get install debootstrap" >&2; exit 2; }
[ "$(id -u)" -eq 0 ] || { echo "error: chroot needs root" >&2; exit 2; }

mounted=()
release() { for m in "${mounted[@]:-}"; do [ -z "$m" ] || umount "$m"; done; }
trap release EXIT
new_root() { # new_root ROOT: a minimal system, with /proc and /dev
  [ -e "$1/etc/debian_version" ] || debootstrap --variant=minbase --include=ca-certificates "$suite" "$1"
  echo force-unsafe-io >"$1/etc/dpkg/dpkg.cfg.d/unsafe-io" # a root that is thrown away need not wait for the disk
  cp /etc/ssl/certs/ca-certificates.crt "$1/etc/ssl/certs/" # what this machine trusts, such as a proxy: for npm
  for part in proc dev; do
    mount --bind "/$part" "$1/$part"
    mounted+=("$1/$part")
  done
}
in_root() { # in_root ROOT COMMAND
  chroot "$1" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
    NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt DEBIAN_FRONTEND=noninteractive CI=true bash -euc "$2"
}

echo "== $suite: build of the programs, and the package"
new_root "$folder/build"
rm -rf "$folder/build/lsmvs/src"
mkdir -p "$folder/build/lsmvs/src"
git ls-files -z | tar c --null -T - | tar x -C "$folder/build/lsmvs/src"
in_root "$folder/build" "cd /lsmvs/src
  scripts/setup.sh --test
  apt-get install -y -q --no-install-recommends file dpkg-dev
  cmake -S . -B /lsmvs/build -G Ninja -DCMAKE_BUILD_TYPE=Release -DLSMVS_BUILD_TESTS=OFF -DLSMVS_BUILD_BENCHMARKS=OFF
  cmake --build /lsmvs/build -j $jobs
  cd /lsmvs/build && rm -f *.deb && cpack
  rm -rf /lsmvs/scene && bin/make_synthetic_workspace --output /lsmvs/scene --shape relief --num_views 6 --width 320 --height 240"

echo "== $suite: the package in a bare root"
new_root "$folder/bare"
rm -rf "$folder/bare/lsmvs"
mkdir "$folder/bare/lsmvs"
cp -r "$folder"/build/lsmvs/build/*.deb "$folder/build/lsmvs/scene" "$folder/bare/lsmvs/"
in_root "$folder/bare" "apt-get update -q
  apt-get install -y -q --no-install-recommends /lsmvs/lsmvs_*.deb
  lsmvs-mesher /lsmvs/scene
  test -s \$(find /lsmvs/scene -name meshed-refined.ply)
  lsmvs --version"

echo "== $suite: tests"
data=${LSMVS_DATA_DIR:-../shared/data} # the scenes, where they are (see tests/README.md)
if [ -d "$data" ]; then
  mkdir -p "$folder/build/lsmvs/shared/data"
  mount --bind "$data" "$folder/build/lsmvs/shared/data"
  mount -o remount,bind,ro "$folder/build/lsmvs/shared/data"
  mounted+=("$folder/build/lsmvs/shared/data")
fi
in_root "$folder/build" "cd /lsmvs/src
  scripts/setup_pycolmap.sh || echo 'note: no pycolmap; the tests that need it are skipped'
  cmake -S /lsmvs/src -B /lsmvs/build -DLSMVS_BUILD_TESTS=ON -DLSMVS_BUILD_BENCHMARKS=ON
  cmake --build /lsmvs/build -j $jobs
  ctest --test-dir /lsmvs/build --output-on-failure -j $jobs"
echo "== $suite: passed"
