#pragma once

#include <petscsnes.h>

#include "hook/filtered_jacobian.hpp"
#include "rule/rule.hpp"
#include "search/line_search_state.hpp"
#include "search/search_options.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// Turns the direction of a filtered Jacobian into Newton's, as far as the unfiltered Hessian is
/// positive along the way: truncated conjugate gradients on H, preconditioned by the linear solver
/// of H + 2 w N (Nocedal and Wright, Numerical Optimization, algorithm 7.1). They begin along the
/// filtered direction and end where they meet negative curvature. An indefinite H so gives Newton's
/// direction where the gradient knows nothing of its negative curvature, and what the filter loses
/// near a minimum is made good by solves with the same factors. Only at weights up to 1/2: where a
/// rule takes more, the model predicts badly, and its minimum is no place to go to. Collective.
PetscErrorCode turn_to_newton(const SearchOptions &options, const Rule &rule, SNES snes,
                              const FilteredJacobian &jacobian, LineSearchState &state,
                              SolveRecord &record);

}  // namespace trefoil
