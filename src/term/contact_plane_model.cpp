// The contact term in a plane of directions: its quadratic model there.

#include "support/petsc_compatibility.hpp"
#include "term/contact_term.hpp"

namespace trefoil {
namespace {

/// A quadratic model on a line or a plane: slopes along the directions, and curvatures.
struct PlaneModel {
  double slope[2] = {0, 0}, curvature[2][2] = {{0, 0}, {0, 0}};
};

/// Adds the curvatures of the filtered Hessian H + N of some of the surface's vertices along
/// directions of the whole surface.
void add_curvatures(const std::vector<std::vector<double>> &d, std::span<const int> vertices,
                    const double *H, const double *N, PlaneModel *model) {
  const auto n = 3 * vertices.size();
  const auto at = [&](std::size_t k, std::size_t i) {
    const int vertex = vertices[i / 3];
    return vertex < 0 ? 0 : d[k][3 * static_cast<std::size_t>(vertex) + i % 3];
  };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      const double entry = H[n * i + j] + (N ? N[n * i + j] : 0);
      for (std::size_t k = 0; k < d.size(); ++k) {
        for (std::size_t l = 0; l < d.size(); ++l) {
          model->curvature[k][l] += at(k, i) * entry * at(l, j);
        }
      }
    }
  }
}

}  // namespace

PetscErrorCode ContactTerm::add_energy_changes(const double *u, std::size_t, int directions,
                                               const double *const *d, int points,
                                               const double *coefficients, double *changes) const {
  Positions x, forces(3 * surface().vertices.size(), 0);
  std::vector<Positions> all(static_cast<std::size_t>(directions));
  PlaneModel model;
  PetscFunctionBeginUser;
  PetscCall(positions(u, &x));
  for (std::size_t k = 0; k < all.size(); ++k) PetscCall(surface_->gather(d[k], &all[k]));
  PetscCall(add_forces(u, x, &forces));
  PetscCall(
      visit_hessians(u, x, [&](std::span<const int> vertices, const double *H, const double *N) {
        add_curvatures(all, vertices, H, N, &model);
      }));
  for (std::size_t k = 0; k < all.size(); ++k) {
    for (std::size_t i = 0; i < forces.size(); ++i) model.slope[k] += forces[i] * all[k][i];
  }
  for (int p = 0; p < points; ++p) {
    const double *c = coefficients + directions * p;
    for (int k = 0; k < directions; ++k) {
      changes[p] += c[k] * model.slope[k];
      for (int l = 0; l < directions; ++l) changes[p] += 0.5 * c[k] * c[l] * model.curvature[k][l];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
