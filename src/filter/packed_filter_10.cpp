#include "filter/packed_filter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace trefoil {
namespace {

constexpr int n = 10, unroll_limit = 10, group_registers = 2;

#include "filter/lane_filter.inc"

}  // namespace

template <>
SplitResult split_packs_of<10>(int packs, const double *K, double *N, int *negative,
                               ReducedSplitExperiment &experiment) noexcept {
  return split_all(packs, K, N, negative, experiment);
}

}  // namespace trefoil
