#pragma once

#include "output/run_report.hpp"
#include "solve/solve.hpp"

namespace trefoil {

/// Fills a report of what the scene is and where its solve ended; the states of load steps, and
/// times, are left alone. Collective.
/// @param end the state that the scene is left at
PetscErrorCode fill_report(Scene &scene, const SolveOutcome &outcome, const StateReport &end,
                           RunReport *report);

}  // namespace trefoil
