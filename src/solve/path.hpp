#pragma once

#include "solve/solve.hpp"

namespace trefoil {

/// Solves a scene in one leap from its starting guess or, where it is hard, on a path. A scene is
/// hard where its guess has more than one element in two hundred inverted. Where the end of a leap
/// has inverted elements the path is tried as well, and counts if its end is lower; and the leap
/// where a path has such an end and no material is nearly incompressible. What is written in t and
/// goes another way than the program would lead it is followed, however hard it is: where it leads
/// cannot be told from its end alone.
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
