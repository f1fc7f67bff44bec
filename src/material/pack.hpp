#pragma once

#include <cstring>

#include "filter/reduced_filter.hpp"

namespace trefoil {

/// Elements that the batched kernels treat at once: as many as the filter does.
inline constexpr int lanes = reduced_lanes;

/// The instruction set of the kernels: the best of this machine, or the one that the environment
/// variable TREFOIL_SIMD names (baseline, avx2 or avx512), for tests.
InstructionSet chosen_instruction_set();

/// One number of each of eight elements. The compiler makes of it what the instruction set has: one
/// AVX-512 register, two of AVX2, four of SSE2. The instruction set is part of the type, so that no
/// inline function that was compiled for one is ever linked into code for another.
template <InstructionSet isa>
struct Pack {
  using Lanes = double __attribute__((vector_size(lanes * sizeof(double))));
  Lanes v;

  Pack() : v{} {}
  Pack(double value) : v(value - Lanes{}) {}  // NOLINT: numbers mix with packs as with numbers
  explicit Pack(const Lanes &value) : v(value) {}

  static Pack load(const double *from) {
    Pack pack;
    std::memcpy(&pack.v, from, sizeof pack.v);
    return pack;
  }
  void store(double *to) const { std::memcpy(to, &v, sizeof v); }

  Pack &operator+=(const Pack &b) {
    v += b.v;
    return *this;
  }
  friend Pack operator+(const Pack &a, const Pack &b) { return Pack(a.v + b.v); }
  friend Pack operator-(const Pack &a, const Pack &b) { return Pack(a.v - b.v); }
  friend Pack operator-(const Pack &a) { return Pack(-a.v); }
  friend Pack operator*(const Pack &a, const Pack &b) { return Pack(a.v * b.v); }

  [[nodiscard]] double sum() const {
    double total = 0;
    for (int lane = 0; lane < lanes; ++lane) total += v[lane];
    return total;
  }
  [[nodiscard]] Pack absolute() const { return Pack(v < 0 ? -v : v); }
};

}  // namespace trefoil
