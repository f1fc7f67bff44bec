#pragma once

#include <algorithm>
#include <limits>

#include "contact/distances.hpp"

namespace trefoil::contact {

/// x + t step.
inline PairPoints moved(const PairPoints &x, const PairPoints &step, double t) {
  PairPoints points;
  for (int a = 0; a < 4; ++a) points[a] = x[a] + t * step[a];
  return points;
}

/// Calls f(a, b) for all points a of the first primitive and b of the second.
template <class Function>
void for_all_corners(PairKind kind, const Function &f) {
  const int firsts = points_of_first(kind), all = points_of_pair(kind);
  for (int a = 0; a < firsts; ++a) {
    for (int b = firsts; b < all; ++b) f(a, b);
  }
}

/// The least n'(x_a - x_b) over the corners of two primitives: how far they are apart along n.
/// Where |n| <= 1 a lower bound of their distance, whatever n is; the distance itself for the
/// normal of the nearest points, since the primitives are convex.
inline double separation(PairKind kind, const Vector3 &n, const PairPoints &x) {
  double least = std::numeric_limits<double>::infinity();
  for_all_corners(kind, [&](int a, int b) { least = std::min(least, dot(n, x[a] - x[b])); });
  return least;
}

}  // namespace trefoil::contact
