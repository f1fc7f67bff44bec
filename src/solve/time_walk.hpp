#pragma once

#include "solve/solve.hpp"

namespace trefoil {

/// A scene's way in time, step by step, each by the same SNES: the minimum of its energy with the
/// step's inertia, from where the last step ended. Steps that fail are halved. The observer sees
/// the start as well. See solve_scene(). Collective.
PetscErrorCode walk_in_time(Scene &scene, const StateObserver &observe, Checkpoint &checkpoint,
                            SolveOutcome *outcome);

}  // namespace trefoil
