#pragma once

#include "hook/filtered_jacobian.hpp"
#include "search/line_search_state.hpp"
#include "search/search_options.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// Where the stop test is met: verifies, with -snes_trefoil_verify_minimum, that the point is a
/// minimum, and leaves a saddle along its negative curvature. Where the unfiltered Hessian has been
/// factored for that, its Newton decrement is the error estimate; a step of it is taken where that
/// is more than a hundred times the energy tolerance. Collective.
/// @param[out] reason why the solve ends; SNES_CONVERGED_ITERATING where it goes on from the trial
/// point of `state`
PetscErrorCode verify_minimum(const SearchOptions &search, const StopOptions &options, SNES snes,
                              FilteredJacobian &jacobian, LineSearchState &state,
                              SolveRecord &record, SNESConvergedReason *reason);

}  // namespace trefoil
