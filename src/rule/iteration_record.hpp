#pragma once

#include <limits>

namespace trefoil {

/// What vouches for a Jacobian that the filter may leave indefinite: the inertia of its factors;
/// else no negative curvature along the direction and in a few Lanczos vectors.
enum class DefiniteBy { nothing, inertia, curvature };

/// One Newton iteration as everybody sees it: rule, monitor, stop test and JSON record read this
/// struct and nothing else. Not-a-number stands for "does not apply".
struct IterationRecord {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  int k = 0;                 ///< iteration number, from 0
  double energy = none;      ///< f(x_k), before the step
  double gradient_norm = 0;  ///< ||g(x_k)||_2
  double weight = 0;         ///< w of the filtered Jacobian H + 2 w N
  double rho = none;         ///< trust-region ratio of the step taken
  double step = 0;           ///< step length taken along the direction; 0: none
  bool truncated = false;    ///< the host allowed no longer step: it teaches a rule nothing
  int refused = 0;           ///< Jacobians before this one that turned out to be indefinite
  DefiniteBy definite_by = DefiniteBy::nothing;  ///< at weights below 1/2
  int trials = 0;                                ///< energies evaluated at trial points
  int shamanskii_steps = 0;                      ///< further steps from the same factors
  int newton_steps = 0;       ///< of conjugate gradients that turned the direction into Newton's
  double decrement = none;    ///< |g'd| / 2 of the full direction d, energy units
  double indefinite = 0;      ///< share of the elements with a negative eigenvalue, 0..1
  int linear_iterations = 0;  ///< of the Krylov solver
  int linear_solves = 0;      ///< since the solve began, that of this direction included
  double seconds = 0;         ///< since the solve began
};

}  // namespace trefoil
