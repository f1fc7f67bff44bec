#include <cmath>

#include "scene/loads.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/pressure_term.hpp"

// What the loads come to on a displaced body: resultants, work, and what rims make of pressures.

namespace trefoil {

/// @param forces 3 a local vertex, what this rank adds to each, not yet summed over ranks
PetscErrorCode Loads::resultant(const std::vector<double> &forces, const double *u,
                                Resultant *resultant) const {
  double sums[6] = {};
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < forces.size(); k += 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, l = (i + 2) % 3;
      sums[i] += forces[k + i];
      sums[3 + i] += (mesh_->coordinates[k + j] + u[k + j]) * forces[k + l] -
                     (mesh_->coordinates[k + l] + u[k + l]) * forces[k + j];
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 6, MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm))));
  *resultant = {{sums[0], sums[1], sums[2]}, {sums[3], sums[4], sums[5]}};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Loads::work(double time, const double *u, double *work) {
  std::vector<double> all;
  PetscFunctionBeginUser;
  *work = 0;
  if (!any()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(forces(time, &all));
  for (std::size_t k = 0; k < all.size(); ++k) *work += all[k] * u[k];
  EnergySums potentials;
  for (const Chosen &load : chosen_) {
    if (load.follower) PetscCall(load.follower->add_energy(u, &potentials));
    if (load.springs) PetscCall(load.springs->add_energy(u, &potentials));
  }
  *work -= potentials.energy;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, work, 1, MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Loads::add_at_rims(const double *u, std::vector<double> *gradient) const {
  std::vector<double> more(mesh_->coordinates.size(), 0);
  PetscFunctionBeginUser;
  if (!any_follows()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const Chosen &load : chosen_) {
    if (!load.follower) continue;
    load.follower->add_surface_force(u, more.data());
    PetscCall(load.follower->add_gradient(u, more.data()));
  }
  PetscCall(sum_at_owners(*mesh_, &more));
  for (std::size_t k = 0; k < more.size(); ++k) (*gradient)[k] -= more[k];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Loads::share_of_loose_rims(const double *u, const std::vector<PetscInt> &dofs,
                                          double *share) const {
  std::vector<double> forces(mesh_->coordinates.size(), 0), rims(mesh_->coordinates.size(), 0);
  double sums[2] = {0, 0};  // at free rims, everywhere
  PetscFunctionBeginUser;
  *share = 0;
  if (!any_follows()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const Chosen &load : chosen_) {
    if (load.follower) load.follower->add_surface_force(u, forces.data());
  }
  PetscCall(sum_at_owners(*mesh_, &forces));
  PetscCall(add_at_rims(u, &rims));
  for (std::size_t k = 0; k < rims.size(); ++k) {
    if (dofs[k] >= 0) sums[0] += std::abs(rims[k]);
    sums[1] += std::abs(forces[k]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm))));
  if (sums[1] > 0) *share = sums[0] / sums[1];
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Loads::report(double time, const double *u, std::vector<LoadReport> *reports) {
  std::vector<double> forces;
  PetscFunctionBeginUser;
  reports->clear();
  if (!options_.gravity.empty()) {
    LoadReport gravity{"gravity", 0, 0, {}};
    forces.assign(mesh_->coordinates.size(), 0);
    PetscCall(add_gravity(time, &forces));
    PetscCall(resultant(forces, u, &gravity.resultant));
    reports->push_back(gravity);
  }
  for (Chosen &load : chosen_) {
    forces.assign(mesh_->coordinates.size(), 0);
    if (load.springs) PetscCall(load.springs->add_gradient(u, forces.data()));
    for (double &force : forces) force = -force;  // which the gradient is the opposite of
    if (load.follower) load.follower->add_surface_force(u, forces.data());
    PetscCall(add_load(load, time, &forces));
    LoadReport report{load.options.name, load.facets.count, load.facets.area, {}};
    PetscCall(resultant(forces, u, &report.resultant));
    reports->push_back(report);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
