#pragma once

#include "search/line_search_state.hpp"
#include "search/solve_record.hpp"

namespace trefoil {

/// Where no step along a descending direction lowers the objective: refuses an objective whose
/// slope is not that of the residual, of which one is then not the other's gradient. Collective.
PetscErrorCode refuse_foreign_objective(LineSearchState &state);

/// Refuses a solve without an objective whose energy falls faster and faster while the residual
/// grows: with the signs of residual and Jacobian turned round a minimum is a maximum. Collective.
PetscErrorCode refuse_endless_descent(MPI_Comm comm, const SolveRecord &record);

}  // namespace trefoil
