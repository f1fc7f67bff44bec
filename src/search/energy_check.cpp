#include "search/energy_check.hpp"

#include <algorithm>
#include <cmath>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode refuse_foreign_objective(LineSearchState &state) {
  const double noise = 1e3 * 8 * PETSC_MACHINE_EPSILON * std::abs(state.energy);
  double ratio = IterationRecord::none;
  double error = IterationRecord::none;
  PetscFunctionBegin;
  if (!state.has_objective) PetscFunctionReturn(PETSC_SUCCESS);
  // The difference quotient of the smallest step that is not drowned in rounding. What it differs
  // by from the one before, of a hundred times that step, bounds its error: where the energy bends
  // within every step whose change can be told, two quotients have nothing in common.
  for (double step = 1e-1; step > 1e-9; step *= 1e-2) {
    bool finite = false;
    PetscCall(evaluate_trial(state, step, &finite));
    if (!finite) continue;
    if (std::abs(state.trial_change) < noise || std::abs(step * state.slope) < noise) break;
    const double quotient = state.trial_change / (step * state.slope);
    error = std::abs(quotient - ratio);
    ratio = quotient;
  }
  PetscCheck(
      !(std::abs(ratio - 1) > 0.5 + error), PetscObjectComm(reinterpret_cast<PetscObject>(state.x)),
      PETSC_ERR_ARG_INCOMP,
      "the objective changes along the direction %.3g times as the residual says, so the "
      "residual is not its gradient: SNESSetFunction() wants plus the gradient of the energy "
      "that SNESSetObjective() returns",
      ratio);
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string find_endless_descent(const SolveRecord &record) {
  // The residual grows as well where a saddle is left, but ends about where it was before the
  // saddle was come near.
  constexpr double endless = 1e6;
  const auto &history = record.history;
  const IterationRecord *next = &record.current;
  std::size_t first = history.size();  // of the iterations since when both grow
  while (first > 0 && next->decrement > history[first - 1].decrement &&
         next->gradient_norm > history[first - 1].gradient_norm) {
    next = &history[--first];
  }
  double before = 0;
  for (std::size_t k = 0; k <= first && k < history.size(); ++k) {
    before = std::max(before, history[k].gradient_norm);
  }
  if (!(before > 0 && record.current.gradient_norm > endless * before)) return "";
  return "the energy falls faster and faster and the residual has grown a million times: the step "
         "is too long for a solve without an energy to compare (SNESSetObjective()), or signs are "
         "turned round (SNESSetFunction() wants plus the gradient of the energy to minimise, and "
         "SNESSetJacobian() plus its Hessian)";
}

}  // namespace trefoil
