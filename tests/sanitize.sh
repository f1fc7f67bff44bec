#!/bin/sh
# The unit tests of filter, rules, search, hook, plugin, mesh readers and materials under the address and
# undefined-behaviour sanitizers, on one rank: builds the preset `sanitize` as far as they need it.
set -eu
cd "$(dirname "$0")/.."
. cmake/environment.sh

alone="filter_test floor_test packed_filter_test reduced_filter_test rule_test polynomial_test
  mesh_check_test mesh_fuzz_test mesh_groups_test mesh_read_test quadratic_mesh_test
  material_test material_values_test polar_test"
by_ranks="hook_test hook_api_test hook_host_test changed_jacobian_test plugin_test plugin_energy_test
  plugin_host_test plugin_lag_test plugin_options_test plugin_record_test plane_search_test
  max_step_test verify_minimum_test"

mkdir -p build
cmake --preset sanitize >build/sanitize.log
# shellcheck disable=SC2086 # one word a target
cmake --build --preset sanitize -j "$(nproc)" --target $alone $by_ranks >>build/sanitize.log || {
  tail -40 build/sanitize.log
  exit 1
}
names=$(printf '%s\n' $alone | paste -sd '|')
names="$names|$(printf '%s_on_1\n' $by_ranks | paste -sd '|')"
# PETSc, MPI and BLAS keep memory to the end, which is no leak of ours.
ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 OMP_NUM_THREADS=1 \
  ctest --test-dir build/sanitize --output-on-failure --timeout 600 -R "^($names)\$"
