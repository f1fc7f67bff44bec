#!/bin/sh
# Builds Trefoil's plugin against a PETSc of one's own, and runs its tests there.
#
#   PETSC_DIR=/path/to/petsc PETSC_ARCH=arch-linux-c-opt sh cmake/check_petsc.sh [build folder]
#
# That PETSc needs real scalars in double precision, shared libraries, and MUMPS. PETSC_ARCH is
# empty for one that is installed. Exits with the status of the tests.
set -eu
cd "$(dirname "$0")/.."
: "${PETSC_DIR:?set PETSC_DIR, and PETSC_ARCH unless PETSc is installed there}"
build=${1:-build/petsc}
pkgconfig=$PETSC_DIR/${PETSC_ARCH:-}/lib/pkgconfig
[ -f "$pkgconfig/PETSc.pc" ] || { echo "$0: there is no $pkgconfig/PETSc.pc; is PETSC_ARCH right?" >&2; exit 1; }

. cmake/environment.sh
export PKG_CONFIG_PATH="$pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}"
tests="plugin_test plugin_host_test plugin_record_test plugin_lag_test plugin_options_test
  plugin_energy_test max_step_test plane_search_test verify_minimum_test hook_test hook_api_test
  hook_host_test changed_jacobian_test rule_test"
hosts="elements plex_fe row_by_row own_rule life_cycle"
cmake -S . -B "$build" -DCMAKE_BUILD_TYPE=Release -DTREFOIL_TESTS=ON
# shellcheck disable=SC2086
cmake --build "$build" -j "${JOBS:-2}" --target libtrefoil $tests $hosts
echo "PETSc $(pkg-config --modversion PETSc) in $pkgconfig"
pattern=$(echo $tests life_cycle | tr ' ' '|')
OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 \
  ctest --test-dir "$build" --output-on-failure -R "^($pattern)(_on_[0-9]+)?$"
