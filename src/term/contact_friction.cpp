// Lagged friction of the contact term: what it has from the state before, and how it follows.

#include <algorithm>
#include <cmath>
#include <utility>

#include "support/petsc_compatibility.hpp"
#include "term/contact_term.hpp"

namespace trefoil {

using contact::FrictionPair;

bool ContactTerm::has_friction() const {
  return parameters_.friction || std::any_of(planes_.begin(), planes_.end(),
                                             [](const auto &plane) { return plane.friction > 0; });
}

/// Whether there is friction in the step under way; the same on all ranks.
bool ContactTerm::rubs() const {
  return has_friction() && slip_time_ > 0 && !ignores_friction_;
}

/// Displacements since the begin of the step. An obstacle's are scaled to the time of the slip,
/// which some schemes of time choose other than the step.
PetscErrorCode ContactTerm::slip(const double *u, Positions *v) const {
  PetscFunctionBeginUser;
  PetscCall(surface_->gather(u, v));
  for (std::size_t k = 0; k < v->size(); ++k) (*v)[k] -= origin_[k];
  if (motions_.empty() || time_ <= accepted_time_) PetscFunctionReturn(PETSC_SUCCESS);
  move_obstacles(time_, v);
  move_obstacles(accepted_time_, v, false);
  const double scale = slip_time_ / (time_ - accepted_time_);
  for (auto k = static_cast<std::size_t>(3 * surface_->obstacle_begin().front()); k < v->size();
       ++k) {
    (*v)[k] *= scale;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The displacement of a half-space since the begin of the step, scaled as those of slip().
contact::Vector3 ContactTerm::drift_of(std::size_t plane) const {
  if (time_ <= accepted_time_) return {};
  const contact::Vector3 moved =
      planes_[plane].displacement(time_) - planes_[plane].displacement(accepted_time_);
  return (slip_time_ / (time_ - accepted_time_)) * moved;
}

/// The part of add_forces() that friction has.
PetscErrorCode ContactTerm::add_friction_forces(const double *u, Positions *forces) const {
  Positions v;
  PetscFunctionBeginUser;
  if (!rubs()) PetscFunctionReturn(PETSC_SUCCESS);
  const double e = parameters_.slip_velocity * slip_time_;
  PetscCall(slip(u, &v));
  contact::add_friction_gradient(friction_, v, e, *forces);
  for (const auto &pairs : plane_friction_) contact::add_friction_gradient(pairs, v, e, *forces);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::set_time(double time) {
  PetscFunctionBeginUser;
  time_ = time;
  if (!has_scheme_) slip_time_ = std::max(0., time_ - accepted_time_);
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    for (FrictionPair &pair : plane_friction_[k]) pair.drift = drift_of(k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::begin_step(const StepState &state) {
  PetscFunctionBeginUser;
  has_scheme_ = true;
  slip_time_ = state.velocity_time;
  PetscCall(set_time(state.time));
  PetscCall(surface_->gather(state.velocity_origin, &origin_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::lag_friction(const double *u) {
  Positions x;
  PetscFunctionBeginUser;
  if (!has_friction()) PetscFunctionReturn(PETSC_SUCCESS);
  ++lags_;
  PetscCall(positions(u, &x));
  friction_.clear();
  if (parameters_.friction) {
    friction_ =
        contact::lagged_friction(surface(), law_, candidates_at(x), x, parameters_.friction);
  }
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    plane_friction_[k].clear();
    if (!(planes_[k].friction > 0)) continue;
    plane_friction_[k] = contact::lagged_friction(surface(), law_, plane_at(k, time_),
                                                  surface_->own_vertices(), x, planes_[k].friction);
    for (FrictionPair &pair : plane_friction_[k]) pair.drift = drift_of(k);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How far the forces of friction at the end of a step are from what they would be with its normal
/// forces; both are parts of a sum over the ranks.
PetscErrorCode ContactTerm::compare_friction_forces(const Positions &before, const Positions &now) {
  const auto length = [](const double *force) { return std::hypot(force[0], force[1], force[2]); };
  std::vector<double> all = before;
  PetscFunctionBeginUser;
  all.insert(all.end(), now.begin(), now.end());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<PetscMPIInt>(all.size()),
                             MPI_DOUBLE, MPI_SUM, surface_->comm()));
  double sum_before = 0, sum_now = 0;
  friction_change_ = 0;
  for (std::size_t k = 0; k < before.size(); k += 3) {
    const double *const one = &all[k], *const other = &all[before.size() + k];
    const double change[3] = {other[0] - one[0], other[1] - one[1], other[2] - one[2]};
    sum_before += length(one);
    sum_now += length(other);
    friction_change_ += length(change);
  }
  friction_force_ = std::max(sum_before, sum_now);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lags friction anew, and keeps by how much that changes it.
PetscErrorCode ContactTerm::renew_friction(const double *u) {
  Positions before(3 * surface().vertices.size(), 0), now = before;
  PetscFunctionBeginUser;
  PetscCall(add_friction_forces(u, &before));
  PetscCall(lag_friction(u));
  PetscCall(add_friction_forces(u, &now));
  PetscCall(compare_friction_forces(before, now));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::find_friction_lag(const double *u, double *lag) {
  const std::vector<FrictionPair> pairs = friction_;
  const std::vector<std::vector<FrictionPair>> of_planes = plane_friction_;
  PetscFunctionBeginUser;
  PetscCall(renew_friction(u));
  *lag = friction_force_ > 0 ? friction_change_ / friction_force_ : 0;
  friction_ = pairs;
  plane_friction_ = of_planes;
  --lags_;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::accept_step(const double *u) {
  constexpr double too_near = 1e-3;
  ContactReport state;
  PetscFunctionBeginUser;
  stiffening_of_step_ = law_.stiffening;
  PetscCall(find_obstacle_forces(u, &obstacle_forces_));
  if (has_friction()) PetscCall(renew_friction(u));
  lags_of_step_ = std::exchange(lags_, 0);
  PetscCall(surface_->gather(u, &origin_));
  accepted_time_ = time_;
  slip_time_ = 0;
  for (auto &pairs : plane_friction_) {
    for (FrictionPair &pair : pairs) pair.drift = {};
  }
  PetscCall(report(u, &state));
  if (state.gap < too_near * law_.distance) law_.stiffening *= 2;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::go_on(const double *u, double time, double stiffening) {
  PetscFunctionBeginUser;
  PetscCall(set_time(time));
  law_.stiffening = stiffening;
  PetscCall(accept_step(u));
  friction_force_ = friction_change_ = 0;  // of a step that the run before has reported
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
