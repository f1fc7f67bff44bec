#pragma once

#include <cmath>

#include "simd/pack.hpp"

namespace trefoil {

// What Pack has for its lanes, for one number: materials and decompositions are written once, with
// these names, for both.

inline double select(bool where, double a, double b) {
  return where ? a : b;
}

inline bool any(bool answer) {
  return answer;
}

using std::abs;
using std::log;
using std::sqrt;

/// The larger of two; where one is not a number, `a`.
template <class Real>
Real larger(const Real &a, const Real &b) {
  return select(a < b, b, a);
}

}  // namespace trefoil
