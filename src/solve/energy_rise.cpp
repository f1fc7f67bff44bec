#include "solve/energy_rise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solve/load_steps.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

double find_energy_rise(const std::vector<StateReport> &states) {
  double least = std::numeric_limits<double>::infinity(), largest_rise = 0, scale = 0;
  for (const StateReport &state : states) {
    const double contact = state.contact ? state.contact->energy : 0;
    const double inner = state.strain_energy + contact + state.motion->kinetic_energy;
    const double total = inner - state.load_work;
    least = std::min(least, total);
    largest_rise = std::max(largest_rise, total - least);
    scale = std::max(scale, std::abs(inner));
  }
  return scale > 0 ? largest_rise / scale : 0;
}

PetscErrorCode is_energy_made(Scene &scene, const std::vector<StateReport> &states, double rise,
                              bool *made) {
  constexpr double tolerated = 0.05;
  bool changes = false;
  PetscFunctionBeginUser;
  *made = rise > tolerated;
  if (!*made) PetscFunctionReturn(PETSC_SUCCESS);
  LoadPath path(scene);
  for (std::size_t k = 1; k < states.size() && !changes; ++k) {
    PetscCall(path.changes(states[k - 1].t, states[k].t, &changes));
  }
  *made = !changes;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
