#pragma once

#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "trefoil/instruction_set.hpp"

namespace trefoil {

/// One number of each of eight elements. The compiler makes of it what the instruction set has: one
/// AVX-512 register, two of AVX2, four of SSE2. The instruction set is part of the type, so that no
/// inline function that was compiled for one is ever linked into code for another.
///
/// Formulas are written as for numbers, in any namespace: + - * /, comparisons, select() in place
/// of a branch, min, max, abs, sqrt, and, one lane after the other, log, log1p, exp, expm1, pow,
/// cbrt and by_lane(). Called without `std::`, they are found by their arguments.
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

  Pack &operator+=(const Pack &b) { return *this = *this + b; }
  Pack &operator-=(const Pack &b) { return *this = *this - b; }
  Pack &operator*=(const Pack &b) { return *this = *this * b; }
  Pack &operator/=(const Pack &b) { return *this = *this / b; }
  friend Pack operator+(const Pack &a, const Pack &b) { return Pack(a.v + b.v); }
  friend Pack operator-(const Pack &a, const Pack &b) { return Pack(a.v - b.v); }
  friend Pack operator-(const Pack &a) { return Pack(-a.v); }
  friend Pack operator*(const Pack &a, const Pack &b) { return Pack(a.v * b.v); }
  friend Pack operator/(const Pack &a, const Pack &b) { return Pack(a.v / b.v); }

  /// A comparison's answer for each lane; no for what is not a number.
  struct Mask {
    using Bits = decltype(Lanes{} < Lanes{});
    Bits bits;  ///< all of a lane's, or none

    friend Mask operator&(const Mask &a, const Mask &b) { return {a.bits & b.bits}; }
    friend Mask operator|(const Mask &a, const Mask &b) { return {a.bits | b.bits}; }
    friend Mask operator!(const Mask &a) { return {~a.bits}; }
    /// Whether the answer is yes for some lane, or for all.
    friend bool any(const Mask &mask) {
      for (int lane = 0; lane < lanes; ++lane) {
        if (mask.bits[lane]) return true;
      }
      return false;
    }
    friend bool all(const Mask &mask) { return !any(!mask); }
  };
  friend Mask operator<(const Pack &a, const Pack &b) { return {a.v < b.v}; }
  friend Mask operator>(const Pack &a, const Pack &b) { return {a.v > b.v}; }
  friend Mask operator<=(const Pack &a, const Pack &b) { return {a.v <= b.v}; }
  friend Mask operator>=(const Pack &a, const Pack &b) { return {a.v >= b.v}; }

  /// a where the answer is yes, else b. Both have been computed; what is not finite in the one that
  /// is not taken harms nothing.
  friend Pack select(const Mask &where, const Pack &a, const Pack &b) {
    return Pack(where.bits ? a.v : b.v);
  }
  /// The smaller and the larger of two; where one is not a number, `a`.
  friend Pack min(const Pack &a, const Pack &b) { return select(b < a, b, a); }
  friend Pack max(const Pack &a, const Pack &b) { return select(a < b, b, a); }
  friend Pack abs(const Pack &a) { return Pack(a.v < 0 ? -a.v : a.v); }
  friend Pack sqrt(const Pack &a) { return a.square_root(); }

  /// function(x) of the number x in each lane: for functions that have no form for packs.
  template <class Function>
  friend Pack by_lane(const Function &function, const Pack &a) {
    Pack result;
    for (int lane = 0; lane < lanes; ++lane) result.v[lane] = function(a.v[lane]);
    return result;
  }
  friend Pack log(const Pack &a) {
    return by_lane([](double x) { return std::log(x); }, a);
  }
  friend Pack log1p(const Pack &a) {
    return by_lane([](double x) { return std::log1p(x); }, a);
  }
  friend Pack exp(const Pack &a) {
    return by_lane([](double x) { return std::exp(x); }, a);
  }
  friend Pack expm1(const Pack &a) {
    return by_lane([](double x) { return std::expm1(x); }, a);
  }
  friend Pack cbrt(const Pack &a) {
    return by_lane([](double x) { return std::cbrt(x); }, a);
  }
  friend Pack pow(const Pack &a, const Pack &exponent) {
    Pack result;
    for (int lane = 0; lane < lanes; ++lane) {
      result.v[lane] = std::pow(a.v[lane], exponent.v[lane]);
    }
    return result;
  }

  [[nodiscard]] double sum() const {
    double total = 0;
    for (int lane = 0; lane < lanes; ++lane) total += v[lane];
    return total;
  }

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
