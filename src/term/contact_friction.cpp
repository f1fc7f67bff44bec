// Lagged friction of the contact term: what it has from the state before, and how it follows.

#include <algorithm>
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

PetscErrorCode ContactTerm::set_time(double time) {
  PetscFunctionBeginUser;
  time_ = time;
  const double elapsed = std::max(0., time_ - accepted_time_);
  if (!has_scheme_) slip_time_ = elapsed;
  const double scale = elapsed > 0 ? slip_time_ / elapsed : 0;
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    const contact::Vector3 moved =
        planes_[k].displacement(time) - planes_[k].displacement(accepted_time_);
    for (FrictionPair &pair : plane_friction_[k]) pair.drift = scale * moved;
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
    contact::Vector3 drift;
    if (!plane_friction_[k].empty()) drift = plane_friction_[k].front().drift;
    plane_friction_[k].clear();
    if (!(planes_[k].friction > 0)) continue;
    plane_friction_[k] = contact::lagged_friction(surface(), law_, plane_at(k, time_),
                                                  surface_->own_vertices(), x, planes_[k].friction);
    for (FrictionPair &pair : plane_friction_[k]) pair.drift = drift;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactTerm::accept_step(const double *u) {
  constexpr double too_near = 1e-3;
  ContactReport state;
  PetscFunctionBeginUser;
  stiffening_of_step_ = law_.stiffening;
  PetscCall(lag_friction(u));
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
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
