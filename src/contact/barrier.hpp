#pragma once

#include <cmath>
#include <limits>

namespace trefoil::contact {

/// The logarithmic barrier of a distance d,
///     b(d) = -dhat (d/dhat - 1)^2 ln(d/dhat) below dhat, 0 beyond, +inf at d <= 0,
/// and its first two derivatives. b has the unit of a length, so that a stiffness in Pa times an
/// area times b is an energy [Li et al. 2020, "Incremental potential contact", in d instead of d^2;
/// the physical unit: Li et al. 2023, "Convergent incremental potential contact"].
/// At dhat b has a triple zero: pairs come and go without a jump, in b'' either.
struct Barrier {
  double value = 0, first = 0, second = 0;
};

/// s = d/dhat, s - 1 and ln s, each to full relative accuracy also where s is nearly 1.
struct BarrierArgument {
  double s, less_one, log;

  BarrierArgument(double d, double dhat)
      : s(d / dhat),
        less_one((d - dhat) / dhat),
        log(s > 0.5 ? std::log1p(less_one) : std::log(s)) {}
};

inline double barrier_value(double d, double dhat) {
  if (!(d > 0)) return std::numeric_limits<double>::infinity();
  if (d >= dhat) return 0;
  const BarrierArgument at(d, dhat);
  return -dhat * at.less_one * at.less_one * at.log;
}

inline Barrier barrier(double d, double dhat) {
  if (!(d > 0)) return {std::numeric_limits<double>::infinity()};
  if (d >= dhat) return {};
  const auto [s, less_one, log_s] = BarrierArgument(d, dhat);
  return {-dhat * less_one * less_one * log_s, -less_one * (2 * log_s + less_one / s),
          -(2 * log_s + less_one * (4 - less_one / s) / s) / dhat};
}

}  // namespace trefoil::contact
