#!/bin/sh
# All tests: installs what is missing, builds, and runs them. Arguments go to ctest, for example
#   sh tests/run.sh -R filter
set -eu
cd "$(dirname "$0")/.."
. cmake/environment.sh
sh cmake/setup.sh tests
ctest --test-dir build --output-on-failure "$@"
