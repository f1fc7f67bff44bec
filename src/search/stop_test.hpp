#pragma once

#include "search/energy.hpp"
#include "search/line_search_state.hpp"
#include "search/search_options.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// The size of the energy at x: the callback's, or what has been gained since the start.
/// Collective.
PetscErrorCode scale_of_energy(Energy &f, const SolveRecord &record, Vec x, double *scale);

/// Whether the present iteration ends the solve, before its direction is taken: the Newton
/// decrement against the absolute and the relative tolerance, or the largest entry of the
/// direction. The record says why. Collective.
/// @param is_newtons the direction is as long as Newton's: none of a filter that shortens it
PetscErrorCode stop_test(const StopOptions &options, Energy &f, const LineSearchState &state,
                         bool is_newtons, SolveRecord &record, bool *stop);

}  // namespace trefoil
