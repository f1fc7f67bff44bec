#pragma once

#include <string>

#include "output/run_report.hpp"
#include "scene/scene.hpp"

namespace trefoil {

/// How reactions and loads of a body in equilibrium add up.
struct ForceBalance {
  double left = 0;  ///< the size of their sum: of what the solver has left on all that is free
  /// `left` over the largest force, or moment over the body's size. They may all be resultants of
  /// nothing, as where one constraint holds both ends: then over a small share of what acts on
  /// single vertices.
  double share = 0;
};

/// Collective.
PetscErrorCode find_force_balance(const Scene &scene, const StateReport &state,
                                  ForceBalance *balance);

/// A warning of forces that are too far from balance, and what to do about them; else empty.
std::string warn_of_imbalance(const Scene &scene, const ForceBalance &balance);

}  // namespace trefoil
