// Negative parts of 9x9 matrices in SIMD lanes. In three passes over a stretch of the batch:
//   classify     LDL' of every pack: which matrices are indefinite? Of the others N = 0.
//   split_group  the indefinite ones, sorted by their number of negative eigenvalues so that the
//                lanes of a group do equal work: Householder, Laguerre for the negative eigenvalues
//                only, their vectors from minors, a proof that nothing is missing or inexact
//   fall_back    the few without proof: split()
#include "filter/reduced_filter.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string_view>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace trefoil {
namespace {

constexpr int n = reduced_rows;
constexpr double eps = std::numeric_limits<double>::epsilon();
constexpr double inf = std::numeric_limits<double>::infinity();

/// Beyond these a power of two cannot scale the matrix and scale it back. split() can.
constexpr double smallest_scalable = std::numeric_limits<double>::min();
constexpr double largest_scalable = std::numeric_limits<double>::max() / 4;

/// Of a column of a matrix scaled to 1: squares below have lost digits to underflow.
constexpr double negligible_square = 1e-280;
/// Laguerre needs 3 to 5 for simple roots, about 25 for a double one.
constexpr int most_iterations = 40;
/// ||T z - lambda z|| / ||T|| that an eigenvector must reach; the contract allows 1e-13.
constexpr double trusted_residual = 4e-15;
/// lambda / ||T|| of what with such a residual cannot be a zero.
constexpr double clearly_negative = -1e-14;
/// Where the search for eigenvalues starts, over ||T||: to the left of zero, because from the edge
/// of a null space, at -1e-15, it would take Laguerre 40 steps to get away.
constexpr double search_from = -1e-6;

constexpr int out_of_range = n + 1;  ///< subnormal, huge, NaN or Inf
constexpr int not_trusted = -2;

/// Place of (i, j), i >= j, in the lower triangle.
constexpr int entry(int i, int j) {
  return i * (i + 1) / 2 + j;
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"  // vectors are passed inside this file only

namespace baseline {
constexpr int part_bytes = 16, group_parts = 2;
typedef double Vector __attribute__((vector_size(16)));
inline Vector square_root(Vector x) {
#if defined(__x86_64__)
  return _mm_sqrt_pd(x);
#else
  return Vector{__builtin_sqrt(x[0]), __builtin_sqrt(x[1])};
#endif
}
#include "filter/reduced_filter_kernel.inc"
}  // namespace baseline

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define TREFOIL_HAS_AVX 1
#pragma GCC push_options
#pragma GCC target("avx2,fma")
namespace avx2 {
constexpr int part_bytes = 32, group_parts = 2;
inline __m256d square_root(__m256d x) {
  return _mm256_sqrt_pd(x);
}
#include "filter/reduced_filter_kernel.inc"
}  // namespace avx2
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512vl,avx2,fma,prefer-vector-width=512")
namespace avx512 {
constexpr int part_bytes = 64, group_parts = 2;
inline __m512d square_root(__m512d x) {
  return _mm512_maskz_sqrt_pd(0xff, x);  // the plain one warns in gcc 12
}
#include "filter/reduced_filter_kernel.inc"
}  // namespace avx512
#pragma GCC pop_options
#endif

#pragma GCC diagnostic pop

/// The two functions of an instruction set.
struct Kernel {
  void (*classify)(const double *K, double *N, double *scale, int *estimate);
  void (*split_group)(const double *K, const double *scale, const int *member, int members,
                      double *N, int *negative);
  int group_lanes;
};

Kernel kernel_of(InstructionSet instructions) {
#ifdef TREFOIL_HAS_AVX
  if (instructions == InstructionSet::avx512) {
    return {avx512::classify, avx512::split_group, avx512::group_lanes};
  }
  if (instructions == InstructionSet::avx2) {
    return {avx2::classify, avx2::split_group, avx2::group_lanes};
  }
#endif
  return {baseline::classify, baseline::split_group, baseline::group_lanes};
}

InstructionSet best_instruction_set() {
  const char *variable = std::getenv("TREFOIL_SIMD");
  const std::string_view limit = variable ? variable : "";
  if (limit == "baseline") return InstructionSet::baseline;
  if (limit != "avx2" && processor_has(InstructionSet::avx512)) return InstructionSet::avx512;
  return processor_has(InstructionSet::avx2) ? InstructionSet::avx2 : InstructionSet::baseline;
}

/// split() of matrix `lane` of a pack; also the judge of what is finite.
SplitStatus fall_back(const double *K, double *N, int lane, int &negative) {
  double full[n * n], part[n * n];
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      full[n * i + j] = full[n * j + i] = K[entry(i, j) * reduced_lanes + lane];
    }
  }
  const SplitResult result = split(n, 1, full, part, &negative);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) N[entry(i, j) * reduced_lanes + lane] = part[n * i + j];
  }
  return result.status;
}

/// A stretch is long enough to fill groups and short enough to stay in the cache.
constexpr int stretch_packs = 64;
constexpr int stretch_size = stretch_packs * reduced_lanes;

/// The matrices of a stretch that may be indefinite, by their estimated number of negative
/// eigenvalues [counting sort]. Returns how many they are.
int sort_indefinite(const int *estimate, int matrices, int *order) {
  int start[n + 2] = {};
  for (int m = 0; m < matrices; ++m) {
    if (1 <= estimate[m] && estimate[m] <= n) ++start[estimate[m] + 1];
  }
  for (int k = 1; k <= n + 1; ++k) start[k] += start[k - 1];
  const int indefinite = start[n + 1];
  for (int m = 0; m < matrices; ++m) {
    if (1 <= estimate[m] && estimate[m] <= n) order[start[estimate[m]]++] = m;
  }
  return indefinite;
}

/// split_reduced() of up to stretch_packs packs. `first` is the number of their first matrix.
void split_stretch(const Kernel &kernel, int first, int packs, const double *K, double *N,
                   int *negative, ReducedSplitExperiment &experiment, SplitResult &result) {
  alignas(64) double scale[stretch_size];
  int order[stretch_size];
  constexpr int pack_size = reduced_entries * reduced_lanes;
  const int matrices = packs * reduced_lanes;
  for (int p = 0; p < packs; ++p) {
    kernel.classify(K + p * pack_size, N + p * pack_size, scale + p * reduced_lanes,
                    negative + p * reduced_lanes);
  }
  if (experiment.distrust) {
    for (int m = 0; m < matrices; ++m) negative[m] = negative[m] == 0 ? 0 : not_trusted;
  }
  const int indefinite = sort_indefinite(negative, matrices, order);
  for (int g = 0; g < indefinite; g += kernel.group_lanes) {
    kernel.split_group(K, scale, order + g, std::min(kernel.group_lanes, indefinite - g), N,
                       negative);
  }
  for (int m = 0; m < matrices; ++m) {
    if (negative[m] == not_trusted || negative[m] == out_of_range) {
      ++experiment.fallbacks;
      const int pack = m / reduced_lanes, lane = m % reduced_lanes;
      const SplitStatus status =
          fall_back(K + pack * pack_size, N + pack * pack_size, lane, negative[m]);
      if (status != SplitStatus::ok && result.first_bad < 0) {
        result.status = status;
        result.first_bad = first + m;
      }
    }
    result.indefinite += negative[m] > 0;
  }
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

SplitResult split_reduced(int packs, const double *K, double *N, int *negative,
                          ReducedSplitExperiment &experiment) noexcept {
  SplitResult result;
  if (packs < 0) {
    result.status = SplitStatus::bad_size;
    return result;
  }
  const Kernel kernel = kernel_of(experiment.instructions);
  experiment.fallbacks = 0;
  for (int done = 0; done < packs; done += stretch_packs) {
    const std::size_t offset = static_cast<std::size_t>(done) * reduced_lanes;
    split_stretch(kernel, done * reduced_lanes, std::min(stretch_packs, packs - done),
                  K + offset * reduced_entries, N + offset * reduced_entries, negative + offset,
                  experiment, result);
  }
  return result;
}

SplitResult split_reduced(int packs, const double *K, double *N, int *negative) noexcept {
  static const InstructionSet best = best_instruction_set();
  ReducedSplitExperiment experiment;
  experiment.instructions = best;
  return split_reduced(packs, K, N, negative, experiment);
}

}  // namespace trefoil
