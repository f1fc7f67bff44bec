#include "search/search_memory.hpp"

#include <cmath>

namespace trefoil {

PetscErrorCode SearchMemory::begin_solve(const SearchOptions &options, bool may_lift) {
  PetscFunctionBeginUser;
  PetscCall(vectors.release());
  keeps_steps = options.kind == TREFOIL_SEARCH_SUBSPACE;
  previous_step_known = false;
  trusts_model = options.trust_start || (options.goes_on && trusts_model);
  if (!options.goes_on) proxy_scale = 1;
  boundary_values_open = may_lift;
  held_rows.clear();
  PetscFunctionReturn(PETSC_SUCCESS);
}

void SearchMemory::learn(const IterationRecord &iteration, double rho_tolerance) {
  const bool predicted = std::abs(iteration.rho - 1) < rho_tolerance;  // false for not-a-number
  trusts_model = trusts_model || (predicted && !iteration.truncated);
}

}  // namespace trefoil
