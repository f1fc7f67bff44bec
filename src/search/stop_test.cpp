#include "search/stop_test.hpp"

#include <algorithm>
#include <cmath>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode scale_of_energy(Energy &f, const SolveRecord &record, Vec x, double *scale) {
  PetscFunctionBeginUser;
  if (f.scale_callback) {
    PetscCall(f.scale(x, scale));
  } else {
    *scale = record.history.empty() ? 0 : record.history.front().energy - record.current.energy;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace {

bool energy_test_is_on(const StopOptions &options, const Energy &f) {
  if (options.energy_tolerance <= 0) return false;
  if (options.energy_tolerance_set) return true;
  return f.scale_callback && options.decrement_tolerance <= 0;
}

/// Whether rounding keeps the decrement up: what it promises is lost in the energy's last digits,
/// and it is no smaller than it was ten iterations ago.
bool decrement_is_rounding(const SolveRecord &record) {
  constexpr std::size_t window = 10;
  const auto &history = record.history;
  const double noise = 8 * PETSC_MACHINE_EPSILON * std::abs(record.current.energy);
  if (history.size() < window || !(record.current.decrement < noise)) return false;
  double smallest = record.current.decrement;
  for (std::size_t k = history.size() - window + 1; k < history.size(); ++k) {
    smallest = std::min(smallest, history[k].decrement);
  }
  return smallest >= history[history.size() - window].decrement;
}

}  // namespace

PetscErrorCode stop_test(const StopOptions &options, Energy &f, const LineSearchState &state,
                         bool is_newtons, SolveRecord &record, bool *stop) {
  const double decrement = record.current.decrement;
  PetscFunctionBeginUser;
  *stop = true;
  if (options.decrement_tolerance > 0 && decrement < options.decrement_tolerance) {
    record.reason = "Newton decrement below -snes_trefoil_decrement_tolerance";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (decrement == 0) {
    record.reason = "the direction is zero";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (energy_test_is_on(options, f)) {
    PetscCall(scale_of_energy(f, record, state.x, &record.energy_scale));
    if (decrement <= options.energy_tolerance * record.energy_scale) {
      record.reason = "predicted energy decrease below -snes_trefoil_energy_tolerance";
      PetscFunctionReturn(PETSC_SUCCESS);
    }
  }
  if (options.direction_tolerance > 0 && is_newtons) {
    double size = 0;
    PetscCall(f.direction_size(state.d, &size));
    if (size <= options.direction_tolerance) {
      record.reason = "the direction is below -snes_trefoil_direction_tolerance";
      PetscFunctionReturn(PETSC_SUCCESS);
    }
  }
  if (decrement_is_rounding(record)) {
    record.reason = "rounding: the Newton decrement falls no further";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  *stop = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
