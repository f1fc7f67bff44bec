#pragma once

#include "contact/distances.hpp"

namespace trefoil::contact {

/// The mollifier of two edges that are nearly parallel, where their nearest points jump:
///     m = (2 - c/e) c/e for c = |a x b|^2 < e, else 1, with a = x1 - x0, b = x3 - x2
/// [Li et al. 2020, "Incremental potential contact", section 5]. C1; zero, with its gradient, at
/// parallel edges, but not its Hessian.
struct Mollifier {
  double value = 1;
  bool active = false;       ///< c < e: the derivatives below are not zero
  double first = 0;          ///< dm/dc
  double second = 0;         ///< d2m/dc2
  Vector3 a, b;              ///< the edges
  Vector3 slope_a, slope_b;  ///< dc/da = 2 b x (a x b), dc/db = 2 (a x b) x a
};

/// e of two edges at rest: 1e-3 |a|^2 |b|^2, an angle of 1.8 degrees.
double mollifier_threshold(const Vector3 &rest_a, const Vector3 &rest_b);

/// The value only, and all of it, for the four points of two edges.
double mollifier_value(const PairPoints &x, double threshold);
Mollifier mollifier(const PairPoints &x, double threshold);

}  // namespace trefoil::contact
