#include "filter/reduced_filter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace trefoil {
namespace {

constexpr int n = reduced_rows, unroll_limit = 9, group_registers = 2;

#include "filter/lane_filter.inc"

}  // namespace

SplitResult split_reduced(int packs, const double *K, double *N, int *negative,
                          ReducedSplitExperiment &experiment) noexcept {
  return split_all(packs, K, N, negative, experiment);
}

SplitResult split_reduced(int packs, const double *K, double *N, int *negative) noexcept {
  ReducedSplitExperiment experiment;
  experiment.instructions = chosen_instruction_set();
  return split_all(packs, K, N, negative, experiment);
}

}  // namespace trefoil
