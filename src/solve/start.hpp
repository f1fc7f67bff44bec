#pragma once

#include "solve/checkpoint.hpp"
#include "solve/solve.hpp"

namespace trefoil {

/// The state that a scene's way starts from, as -initial says. Collective.
PetscErrorCode make_start(Scene &scene, SolveOutcome *outcome);

/// How the start came about, for a run that goes on.
void save_start(const SolveOutcome &outcome, SavedRun *run);
PetscErrorCode load_start(const Checkpoint &checkpoint, SolveOutcome *outcome);

}  // namespace trefoil
