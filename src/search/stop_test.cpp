#include <algorithm>
#include <cmath>

#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode scale_of_energy(SolveContext &context, Vec x, double *scale) {
  PetscFunctionBeginUser;
  if (context.energy_scale) {
    PetscReal value = 0;
    PetscCall(context.energy_scale(context.snes, x, &value, context.energy_scale_context));
    *scale = value;
  } else {
    *scale = context.history.empty() ? 0 : context.history.front().energy - context.current.energy;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace {

bool energy_test_is_on(const SolveContext &context) {
  const SolverOptions &options = context.options;
  if (options.energy_tolerance <= 0) return false;
  if (options.energy_tolerance_set) return true;
  return context.energy_scale && options.decrement_tolerance <= 0;
}

/// Whether rounding keeps the decrement up: what it promises is lost in the energy's last digits,
/// and it is no smaller than it was ten iterations ago.
bool decrement_is_rounding(const SolveContext &context) {
  constexpr std::size_t window = 10;
  const auto &history = context.history;
  const double noise = 8 * PETSC_MACHINE_EPSILON * std::abs(context.current.energy);
  if (history.size() < window || !(context.current.decrement < noise)) return false;
  double smallest = context.current.decrement;
  for (std::size_t k = history.size() - window + 1; k < history.size(); ++k) {
    smallest = std::min(smallest, history[k].decrement);
  }
  return smallest >= history[history.size() - window].decrement;
}

}  // namespace

PetscErrorCode stop_test(SolveContext &context, Vec x, bool *stop) {
  const SolverOptions &options = context.options;
  const double decrement = context.current.decrement;
  PetscFunctionBeginUser;
  *stop = options.decrement_tolerance > 0 && decrement < options.decrement_tolerance;
  if (*stop) {
    context.summary.reason = "Newton decrement below -snes_trefoil_decrement_tolerance";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (decrement == 0) {
    *stop = true;
    context.summary.reason = "the direction is zero";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (energy_test_is_on(context)) {
    double scale = 0;
    PetscCall(scale_of_energy(context, x, &scale));
    context.summary.energy_scale = scale;
    *stop = decrement <= options.energy_tolerance * scale;
    if (*stop)
      context.summary.reason = "predicted energy decrease below -snes_trefoil_energy_tolerance";
  }
  if (!*stop && decrement_is_rounding(context)) {
    *stop = true;
    context.summary.reason = "rounding: the Newton decrement falls no further";
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
