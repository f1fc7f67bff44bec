// What obstacles exert on bodies.

#include "support/petsc_compatibility.hpp"
#include "term/contact_term.hpp"

namespace trefoil {
namespace {

/// Adds vectors of vertices up, times a factor.
void add_up(std::span<const double> of_vertices, double factor, double *sum) {
  for (std::size_t k = 0; k < of_vertices.size(); ++k) sum[k % 3] += factor * of_vertices[k];
}

}  // namespace

/// An obstacle of a surface exerts the derivative of the energy by its position: the body's
/// vertices feel the negative of theirs, and moving all alike changes nothing. A half-space has no
/// vertices.
PetscErrorCode ContactTerm::find_obstacle_forces(const double *u,
                                                 std::vector<ObstacleForce> *forces) const {
  const std::size_t surfaces = motions_.size(), size = 3 * surface().vertices.size();
  const std::vector<int> &begin = surface_->obstacle_begin();
  std::vector<double> sums(3 * (surfaces + planes_.size()), 0);
  const double e = parameters_.slip_velocity * slip_time_;
  Positions x, v;
  PetscFunctionBeginUser;
  forces->clear();
  if (sums.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(positions(u, &x));
  if (rubs()) PetscCall(slip(u, &v));
  if (surfaces > 0) {
    Positions gradient(size, 0);
    contact::add_contact_gradient(surface(), law_, candidates_at(x), x, gradient);
    if (rubs()) contact::add_friction_gradient(friction_, v, e, gradient);
    for (std::size_t k = 0; k < surfaces; ++k) {
      const auto first = static_cast<std::size_t>(3 * begin[k]);
      const auto last = static_cast<std::size_t>(3 * begin[k + 1]);
      add_up(std::span(gradient).subspan(first, last - first), 1, &sums[3 * k]);
    }
  }
  for (std::size_t k = 0; k < planes_.size(); ++k) {
    Positions gradient(size, 0);
    contact::add_half_space_gradient(surface(), law_, plane_at(k, time_), surface_->own_vertices(),
                                     x, gradient);
    if (rubs()) contact::add_friction_gradient(plane_friction_[k], v, e, gradient);
    add_up(gradient, -1, &sums[3 * (surfaces + k)]);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<PetscMPIInt>(sums.size()),
                             MPI_DOUBLE, MPI_SUM, surface_->comm()));
  for (std::size_t k = 0; k < sums.size() / 3; ++k) {
    const int body = surface_->first_obstacle() + static_cast<int>(k);
    forces->push_back({k < surfaces ? surface_->name_of_obstacle(body) : planes_[k - surfaces].name,
                       {sums[3 * k], sums[3 * k + 1], sums[3 * k + 2]}});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
