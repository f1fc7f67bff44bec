#pragma once

#include <petscsnes.h>

#include "search/line_search_state.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// Where a Krylov solver has failed: makes its preconditioner anew, coarse spaces that were kept
/// from an older Jacobian as well, and solves once more. What the second solve says is in the KSP.
/// Collective.
PetscErrorCode solve_with_fresh_preconditioner(KSP ksp, LineSearchState &state,
                                               SolveRecord &record);

/// Goes on with a linear solve that ended with its residual above a thousandth of the first one, or
/// below an absolute tolerance, until it is there: conjugate gradients from below approach the
/// decrement g'H^-1 g / 2, and a stop test must not be met because they ended early. The direction
/// and its decrement are replaced. Collective.
/// @param[out] refined whether there was anything to do
PetscErrorCode refine_direction(KSP ksp, LineSearchState &state, SolveRecord &record,
                                bool *refined);

/// The record gets |H d + g| / |g| of the direction that has met a stop test, H the matrix of the
/// linear solver; the reason of the end says where options have kept that one from being exact
/// enough. Collective.
PetscErrorCode measure_residual(KSP ksp, const LineSearchState &state, SolveRecord &record);

}  // namespace trefoil
