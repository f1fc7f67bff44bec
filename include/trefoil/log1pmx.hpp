#pragma once

#include "trefoil/branch_free.hpp"

namespace trefoil {

/// log(1 + x), and what is left of it less x: of -mu log J where a term mu (J - 1) balances it.
template <class Real>
struct Logarithm {
  Real log1p, log1pmx;  ///< log(1 + x) and log(1 + x) - x
};

/// Both to a few times rounding of themselves, and at the price of one. For small x the second is
/// -x^2/2, which a difference of the two would lose: with r = x / (2 + x),
/// log(1 + x) = 2 artanh r = 2 (r + r^3/3 + r^5/5 + ...), and 2 r - x = -x r.
template <class Real>
Logarithm<Real> logarithm(const Real &x) {
  constexpr double largest = 0.25;  // r^2 < 0.0205: what follows the term r^19 is below rounding
  const Real r = x / (2.0 + x), square = r * r;
  Real sum = Real(2.0 / 19);
  for (int odd = 17; odd >= 3; odd -= 2) sum = sum * square + 2.0 / odd;
  const Real series = r * (square * sum - x);
  const auto is_small = abs(x) <= Real(largest);
  if (all(is_small)) return {x + series, series};
  const Real far = log(1.0 + x);
  return {select(is_small, x + series, far), select(is_small, series, far - x)};
}

template <class Real>
Real log1pmx(const Real &x) {
  return logarithm(x).log1pmx;
}

}  // namespace trefoil
