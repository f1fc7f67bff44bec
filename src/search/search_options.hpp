#pragma once

#include "trefoil.h"

namespace trefoil {

/// What the search is tuned by; options.cpp has the option names and help texts.
struct SearchOptions {
  TrefoilSearch kind = TREFOIL_SEARCH_ARMIJO;
  TrefoilProxy proxy = TREFOIL_PROXY_HESSIAN;
  bool goes_on = false;      ///< from where the last solve of the SNES has ended
  double shrink = 0.8;       ///< from one step length to the next
  double armijo = 1e-8;      ///< share of the predicted decrease to reach
  bool trust_start = false;  ///< the start has no crushed elements
  /// With search `subspace`: most Shamanskii steps an iteration; -1: 8 where the linear solver is
  /// direct, none where it is iterative and each costs nearly as much as the first.
  int shamanskii_steps = -1;
  double shamanskii_gain = 0.03;  ///< least share of the first step's decrease to go on
  /// Most steps of conjugate gradients that turn a filtered direction into Newton's; -1: 8 where
  /// the rule prefers that and the linear solver is direct, else none.
  int newton_steps = -1;
};

/// When a solve has come to its end.
struct StopOptions {
  double decrement_tolerance = 0;     ///< energy units; 0: off
  double energy_tolerance = 1e-8;     ///< predicted decrease over energy scale; 0: off
  bool energy_tolerance_set = false;  ///< by the user, so decrement_tolerance does not turn it off
  double direction_tolerance = 0;     ///< Energy::direction_size(); 0: off
  bool takes_last = false;            ///< the direction that meets a test is followed, then it ends
  bool verify_minimum = false;        ///< look for negative curvature where the stop test is met
  /// Of the solve's applications of the preconditioner, a set-up counting as forty: as many more
  /// may be spent on the verification, and at least thirty; 0: no bound.
  double verify_share = 0;
  bool verify_minimum_set = false;  ///< by the user, so decrement_tolerance does not turn it off
};

}  // namespace trefoil
