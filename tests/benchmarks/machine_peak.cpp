#include "machine_peak.hpp"

#include <algorithm>
#include <chrono>
#include <vector>

#include "trefoil/pack.hpp"

namespace trefoil {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Sixteen chains of multiply-adds hide each other's latency. Returns flops.
#define TREFOIL_MULTIPLY_ADDS                                                  \
  Vector x[16];                                                                \
  for (int i = 0; i < 16; ++i) x[i] = Vector{} + 1e-3 * i;                     \
  const Vector a = Vector{} + 0.999, b = Vector{} + 1e-3;                      \
  for (long k = 0; k < steps; ++k) {                                           \
    _Pragma("GCC unroll 16") for (int i = 0; i < 16; ++i) x[i] = x[i] * a + b; \
  }                                                                            \
  double sum = 0;                                                              \
  for (int i = 0; i < 16; ++i) sum += x[i][0];                                 \
  *sink = sum;                                                                 \
  return 2.0 * 16 * static_cast<double>(steps * (sizeof(Vector) / sizeof(double)))

double baseline(long steps, volatile double *sink) {
  typedef double Vector __attribute__((vector_size(16)));
  TREFOIL_MULTIPLY_ADDS;
}
#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) double avx2(long steps, volatile double *sink) {
  typedef double Vector __attribute__((vector_size(32)));
  TREFOIL_MULTIPLY_ADDS;
}
__attribute__((target("avx512f,fma,prefer-vector-width=512"))) double avx512(
    long steps, volatile double *sink) {
  typedef double Vector __attribute__((vector_size(64)));
  TREFOIL_MULTIPLY_ADDS;
}
#endif

double multiply_adds(long steps, volatile double *sink) {
#if defined(__x86_64__)
  if (chosen_instruction_set() == InstructionSet::avx512) return avx512(steps, sink);
  if (chosen_instruction_set() == InstructionSet::avx2) return avx2(steps, sink);
#endif
  return baseline(steps, sink);
}

}  // namespace

MachinePeak measure_machine_peak() {
  MachinePeak peak{0, 0};
  volatile double sink = 0;
  for (int i = 0; i < 10; ++i) {
    const auto begin = Clock::now();
    const double flops = multiply_adds(500000, &sink);
    peak.flops_per_second = std::max(peak.flops_per_second, flops / seconds_since(begin));
  }
  constexpr std::size_t length = 16 << 20;  // 128 MB an array
  std::vector<double> a(length, 0), b(length, 1), c(length, 2);
  for (int i = 0; i < 5; ++i) {
    const auto begin = Clock::now();
    for (std::size_t k = 0; k < length; ++k) a[k] = b[k] + 0.5 * c[k];
    sink = a[static_cast<std::size_t>(i)];
    peak.bytes_per_second =
        std::max(peak.bytes_per_second, 3.0 * length * sizeof(double) / seconds_since(begin));
  }
  return peak;
}

}  // namespace trefoil
