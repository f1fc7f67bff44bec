#!/bin/sh
# All tests: installs what is missing, builds, and runs them, some under sanitizers as well. Arguments go
# to ctest, for example
#   sh tests/run.sh -R filter
# Tests with FEniCSx, with PETSc's tutorials and in a browser say `skipped` unless their packages are
# there; TREFOIL_TEST_PACKAGES="python3-dolfinx libpetsc3.18-dev-examples chromium" installs them first.
set -eu
cd "$(dirname "$0")/.."
. cmake/environment.sh
# shellcheck disable=SC2086 # one word a package
sh cmake/setup.sh tests ${TREFOIL_TEST_PACKAGES:-}
status=0
[ $# -gt 0 ] || sh tests/sanitize.sh || status=$?
ctest --test-dir build --output-on-failure "$@" || status=$?
exit $status
