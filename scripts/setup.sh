#!/usr/bin/env bash
# Installs what lsmvs is built from and runs with, on Debian 12.
#   scripts/setup.sh          to build and use it
#   scripts/setup.sh --test   also what only the tests and the development scripts need
# Does nothing, and needs no root, where everything is there already.
set -euo pipefail

build_packages=(
  build-essential cmake ninja-build ccache mold git pkg-config ca-certificates
  libeigen3-dev      # vectors and rotations in every header
  libfmt-dev         # messages
  libtbb-dev         # threads
  libopencv-dev      # image codecs and resampling
  libcgal-dev        # Delaunay tetrahedralisation, exact predicates
  libboost-dev       # Asio; headers that CGAL includes
  libceres-dev       # robust least squares
  libgoogle-glog-dev # the log
  libsqlite3-dev     # COLMAP's database
  libcli11-dev       # command lines and ini files
  nlohmann-json3-dev # run.json, reports
  libxxhash-dev      # content hashes
  libhwy-dev         # SIMD chosen at run time
  libembree-dev      # ray casting: evaluation, rendering
  libnanoflann-dev   # nearest neighbours
  libmeshoptimizer-dev # compresses GLB files
  libstb-dev         # packs charts on texture pages
  libzstd-dev        # packs compact depth maps
  zlib1g-dev         # packs the comparison page's meshes
  colmap             # undistorts, makes sparse models
)
test_packages=(
  libgtest-dev libgmock-dev libbenchmark-dev
  libboost-graph-dev # reference minimum cut
  clang clang-format clang-tidy
  python3 python3-venv
  slurm-wlm munge parallel # runs on several machines
  chromium           # looks at the comparison page
)

# They bundle the comparison page. Node from elsewhere brings its own npm, which Debian's would conflict with.
command -v npm >/dev/null && command -v node >/dev/null || build_packages+=(nodejs npm)

packages=("${build_packages[@]}" "${test_packages[@]}")
[ "${1:-}" = --test ] || packages=("${build_packages[@]}")

missing=()
for package in "${packages[@]}"; do
  dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

echo "Installing: ${missing[*]}"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "error: not root and no sudo; install by hand: ${missing[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
export DEBIAN_FRONTEND=noninteractive
"${as_root[@]}" apt-get update -q
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -q --no-install-recommends "${missing[@]}"
