#pragma once

#include "scene/constraints.hpp"
#include "time/integrator.hpp"

namespace trefoil {

/// Where what is held is at a time, with its velocity and acceleration by differences of its
/// formulas over a step to both sides; at the ends of the scene's time, to one. All of second
/// order; where a formula has a kink the accelerations of the steps about it add up to the change
/// of its velocity. Collective; errors as those of Constraints::hold().
/// @param end of the scene's time   @param length of the step
PetscErrorCode find_held_motion(Constraints &constraints, double end, double time, double length,
                                HeldMotion *motion);

}  // namespace trefoil
