#include "term/term.hpp"

#include <vector>

namespace trefoil {

PetscErrorCode Term::add_energy_changes(const double *u, std::size_t size, int directions,
                                        const double *const *d, int points,
                                        const double *coefficients, double *changes) const {
  EnergySums before;
  PetscFunctionBeginUser;
  PetscCall(add_energy(u, &before));
  std::vector<double> moved(size);
  for (int point = 0; point < points; ++point) {
    const double *c = coefficients + directions * point;
    for (std::size_t i = 0; i < size; ++i) {
      moved[i] = u[i];
      for (int k = 0; k < directions; ++k) moved[i] += c[k] * d[k][i];
    }
    EnergySums after;
    PetscCall(add_energy(moved.data(), &after));
    changes[point] += after.energy - before.energy;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Term::add_hessian(const double *u, StencilSink &sink) const {
  static_cast<void>(u), static_cast<void>(sink);
  return PETSC_SUCCESS;
}

}  // namespace trefoil
