#pragma once

#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

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
  friend Pack operator/(const Pack &a, const Pack &b) { return Pack(a.v / b.v); }

  /// A comparison's answer for each lane; no for what is not a number.
  struct Mask {
    decltype(Lanes{} < Lanes{}) bits;  ///< all of a lane's, or none

    friend bool any(const Mask &mask) {
      for (int lane = 0; lane < lanes; ++lane) {
        if (mask.bits[lane]) return true;
      }
      return false;
    }
  };
  friend Mask operator<(const Pack &a, const Pack &b) { return {a.v < b.v}; }
  friend Mask operator>(const Pack &a, const Pack &b) { return {a.v > b.v}; }
  friend Mask operator<=(const Pack &a, const Pack &b) { return {a.v <= b.v}; }
  friend Pack select(const Mask &where, const Pack &a, const Pack &b) {
    return Pack(where.bits ? a.v : b.v);
  }
  friend Pack sqrt(const Pack &a) { return a.square_root(); }
  friend Pack log(const Pack &a) {
    Pack result;
    for (int lane = 0; lane < lanes; ++lane) result.v[lane] = std::log(a.v[lane]);
    return result;
  }

  [[nodiscard]] double sum() const {
    double total = 0;
    for (int lane = 0; lane < lanes; ++lane) total += v[lane];
    return total;
  }
  [[nodiscard]] Pack absolute() const { return Pack(v < 0 ? -v : v); }
  friend Pack abs(const Pack &a) { return a.absolute(); }

 private:
  /// The compiler has no square root of a vector and makes none of a loop that may set errno.
  [[nodiscard]] Pack square_root() const {
    Pack result;
#if defined(__AVX512F__)
    constexpr int width = 8;
    // With a mask, of all lanes, because gcc 12 warns of its own header without one.
    const auto root = [](const double *x) {
      return _mm512_maskz_sqrt_pd(0xff, _mm512_loadu_pd(x));
    };
#elif defined(__AVX__)
    constexpr int width = 4;
    const auto root = [](const double *x) { return _mm256_sqrt_pd(_mm256_loadu_pd(x)); };
#elif defined(__SSE2__)
    constexpr int width = 2;
    const auto root = [](const double *x) { return _mm_sqrt_pd(_mm_loadu_pd(x)); };
#else
    constexpr int width = 1;
    const auto root = [](const double *x) { return std::sqrt(*x); };
#endif
    for (int lane = 0; lane < lanes; lane += width) {
      const auto part = root(reinterpret_cast<const double *>(&v) + lane);
      std::memcpy(reinterpret_cast<double *>(&result.v) + lane, &part, sizeof part);
    }
    return result;
  }
};

}  // namespace trefoil
