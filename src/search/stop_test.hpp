#pragma once

#include "search/energy.hpp"
#include "search/search_options.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// The size of the energy at x: the callback's, or what has been gained since the start.
/// Collective.
PetscErrorCode scale_of_energy(Energy &f, const SolveRecord &record, Vec x, double *scale);

/// Whether the present iteration ends the solve, before its direction is taken: the Newton
/// decrement against the absolute and the relative tolerance. The record says why. Collective.
PetscErrorCode stop_test(const StopOptions &options, Energy &f, Vec x, SolveRecord &record,
                         bool *stop);

}  // namespace trefoil
