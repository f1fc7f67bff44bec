#pragma once

#include <span>
#include <vector>

#include "contact/candidates.hpp"
#include "contact/distances.hpp"

namespace trefoil::contact {

/// How near two primitives may come in a step.
struct StepLimits {
  double share = 0.9;   ///< s: a step may use up this share of the distance at its start
  double touching = 0;  ///< xi: what is no farther apart does not move at all
  /// Distances beyond this one count as this one: pairs that are far from each other, and stay so,
  /// do not shorten the step. Infinity: each keeps its own share.
  double far = std::numeric_limits<double>::infinity();

  /// The distance that has to be left of d.
  [[nodiscard]] double least(double d) const {
    return touching + (1 - share) * (std::min(d, far) - touching);
  }
};

/// The largest t <= 1 for which the distance of two primitives, moving from x to x + t step, is
/// proven to stay at least limits.least(d at x) on all of [0, t]; 1 where it is for the whole step.
///
/// Safe advances are added up [conservative advancement: Mirtich 1996; as additive CCD: Li et al.
/// 2021, "Codimensional incremental potential contact"], but not by a bound on speeds. A plane
/// between the primitives, with normal n,
///  - held still keeps them apart until the first corner reaches it: head-on that is the whole way
///    in one advance, and sliding along the plane costs nothing;
///  - turned from n0 to n1, the normals before and after a trial advance, keeps them apart where
///    n(tau)'(x_a - x_b)(tau), a quadratic in tau for each pair of corners, stays large enough; its
///    Bernstein coefficients n0'r0, (n0'r1 + n1'r0) / 2, n1'r1 tell, and |n(tau)| <= 1. A rotation
///    by up to 84 degrees passes at once, for s = 0.9.
/// Neither trusts the classification of the distance: a wrong normal costs advances, not safety. It
/// ends at the first t < 1 where all but a hundredth of the allowed approach is used up, or after
/// 1000 advances. The points are taken relative to one of them, so that rounding errors are eps
/// times the pair's size and motion; pairs no farther apart than a hundred of these touch.
/// @param limit  steps beyond it are of no interest: returns `limit` then; does not change others
double allowed_step(PairKind kind, const PairPoints &x, const PairPoints &step,
                    const StepLimits &limits, double limit = 1);

/// The smallest allowed step of a list of pairs.
struct AllowedStep {
  double step = 1;
  int pair = -1;  ///< the first one that allows no more, -1 where all allow the whole limit
};

/// @param limit  the share of the step for which the list is complete, see SweptCandidates
AllowedStep allowed_step(const Surface &surface, std::span<const ContactPair> pairs,
                         std::span<const double> x, std::span<const double> step,
                         const StepLimits &limits, double limit = 1);

}  // namespace trefoil::contact
