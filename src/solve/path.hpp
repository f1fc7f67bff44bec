#pragma once

#include "solve/solve.hpp"

namespace trefoil {

/// Whether a scene may be led on a path of the program's own accord: unless the user says from
/// where (-initial other than auto), in what steps (-load_steps) or by what (-snes_type) it is
/// solved. Collective.
PetscErrorCode may_take_path(const SceneOptions &options, bool *may);

/// Solves a scene in one leap from its starting guess or, where it is hard, on a path. A scene is
/// hard where its guess has more than one element in two hundred inverted. Where the end of a leap
/// has inverted elements the path is tried as well, and counts if its end is lower; and the leap
/// where a path has such an end and no material is nearly incompressible.
///
/// A path leads from rest to the loads and displacements in a few steps, a third of the way each:
/// all but the last are solved only as far as the next one needs. Where volume is dear, the minimum
/// that one leap finds depends on how the guess has folded the body; loading leads to the lowest
/// one known. A step is halved, down to an eighth of it, where it fails, or where what it starts
/// from has more than one element in a hundred inverted. Where no shorter one is left the leap
/// counts.
/// @param observe loose states are observed as well; the end is the last
/// Collective.
PetscErrorCode solve_by_leap_or_path(Scene &scene, const StateObserver &observe,
                                     Checkpoint &checkpoint, SolveOutcome *outcome);

}  // namespace trefoil
