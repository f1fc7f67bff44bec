#pragma once

#include <algorithm>
#include <cmath>

#include "trefoil/pack.hpp"

namespace trefoil {

// What Pack has for its lanes, for one number: materials and decompositions are written once, with
// these names, for both.

inline double select(bool where, double a, double b) {
  return where ? a : b;
}
inline bool any(bool answer) {
  return answer;
}
inline bool all(bool answer) {
  return answer;
}

using std::abs;
using std::cbrt;
using std::exp;
using std::expm1;
using std::log;
using std::log1p;
using std::max;
using std::min;
using std::pow;
using std::sqrt;

}  // namespace trefoil
