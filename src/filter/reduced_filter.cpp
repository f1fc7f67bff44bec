#include "filter/reduced_filter.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace trefoil {
namespace {

constexpr int n = reduced_rows, unroll_limit = 9, group_registers = 2;

#include "filter/lane_filter.inc"

InstructionSet best_instruction_set() {
  const char *variable = std::getenv("TREFOIL_SIMD");
  const std::string_view limit = variable ? variable : "";
  if (limit == "baseline") return InstructionSet::baseline;
  if (limit != "avx2" && processor_has(InstructionSet::avx512)) return InstructionSet::avx512;
  return processor_has(InstructionSet::avx2) ? InstructionSet::avx2 : InstructionSet::baseline;
}

}  // namespace

bool processor_has(InstructionSet instructions) noexcept {
#ifdef TREFOIL_HAS_AVX
  if (instructions == InstructionSet::avx512) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma");
  }
  if (instructions == InstructionSet::avx2) {
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  }
#endif
  return instructions == InstructionSet::baseline;
}

InstructionSet filter_instruction_set() noexcept {
  static const InstructionSet best = best_instruction_set();
  return best;
}

SplitResult split_reduced(int packs, const double *K, double *N, int *negative,
                          ReducedSplitExperiment &experiment) noexcept {
  return split_all(packs, K, N, negative, experiment);
}

SplitResult split_reduced(int packs, const double *K, double *N, int *negative) noexcept {
  ReducedSplitExperiment experiment;
  experiment.instructions = filter_instruction_set();
  return split_all(packs, K, N, negative, experiment);
}

}  // namespace trefoil
