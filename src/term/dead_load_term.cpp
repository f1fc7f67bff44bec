#include "term/dead_load_term.hpp"

#include <cmath>

namespace trefoil {

PetscErrorCode DeadLoadTerm::set_time(double time) {
  PetscFunctionBeginUser;
  if (forces_at_) PetscCall(forces_at_(time, &forces_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DeadLoadTerm::add_energy(const double *u, EnergySums *sums) const {
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k + 2 < forces_.size(); k += 3) {
    const double work = forces_[k] * u[k] + forces_[k + 1] * u[k + 1] + forces_[k + 2] * u[k + 2];
    sums->energy -= work;
    sums->load_work += work;
    sums->scale += std::abs(work);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DeadLoadTerm::add_gradient(const double *u, double *gradient) const {
  PetscFunctionBeginUser;
  static_cast<void>(u);
  for (std::size_t k = 0; k < forces_.size(); ++k) gradient[k] -= forces_[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
