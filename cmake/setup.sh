#!/bin/sh
# Installs what is missing, by Debian's package names, and builds Release into build/.
#   sh cmake/setup.sh [tests [PACKAGE ...]]     with `tests`: what the tests need as well
# With TREFOIL_WARNINGS_AS_ERRORS=ON a warning ends the build.
set -eu
cd "$(dirname "$0")/.."

packages="g++ cmake make pkg-config
  petsc-dev libpetsc-real-dev libopenmpi-dev openmpi-bin libhdf5-openmpi-dev libmetis-dev
  libopenblas0-pthread libopenblas-dev libmuparser-dev libyaml-dev nlohmann-json3-dev
  python3 python3-numpy python3-h5py python3-matplotlib libjs-three"
tests=OFF
if [ "${1:-}" = tests ]; then
  shift
  packages="$packages libgtest-dev python3-meshio $*"
  tests=ON
fi

missing=""
for package in $packages; do
  dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' ||
    missing="$missing $package"
done
if [ -n "$missing" ]; then
  echo "Trefoil installs these Debian packages:$missing"
  as_root=""
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || {
      echo "setup.sh: neither root nor sudo; ask an administrator for:$missing" >&2
      exit 1
    }
    as_root="sudo"
  fi
  $as_root apt-get update -q
  # shellcheck disable=SC2086 # one word a package
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
fi

jobs=$(nproc)
cmake -S . -B build -DCMAKE_BUILD_TYPE=Release -DTREFOIL_TESTS="$tests" \
  -DTREFOIL_WARNINGS_AS_ERRORS="${TREFOIL_WARNINGS_AS_ERRORS:-OFF}"
cmake --build build -j "$jobs"
