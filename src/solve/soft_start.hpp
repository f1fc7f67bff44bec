#pragma once

#include <vector>

#include "solve/run_record.hpp"
#include "solve/scene_solver.hpp"

namespace trefoil {

/// Whether a scene's start is softened: its elements have a pressure of their own, and a material
/// is so nearly incompressible (nu > .495) that a softer body is much easier.
bool softens_start(const Scene &scene);

/// Leads the start of such a scene to where the same body would nearly be at Poisson's ratio .48,
/// by a loose solve. From there the volume is nearly right, and few iterations are left whatever
/// the ratio: those of PressureSteps, where factors solve. Where that solve fails the start stays
/// as it was. It is not saved: a run that is stopped within begins it anew. Collective.
/// @param head_start seconds that went before
/// @param records of the loose solve, as load step 0, and of the steps are added
PetscErrorCode soften_start(Scene &scene, double head_start, Checkpoint &checkpoint,
                            SolveOutcome *outcome, std::vector<AttemptRecord> *records);

}  // namespace trefoil
