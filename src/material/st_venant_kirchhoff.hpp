#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// Saint Venant's and Kirchhoff's energy, Hooke's law for Green's strain E = (F'F - I)/2:
///   psi(F) = mu E:E + lambda/2 (tr E)^2,
/// with Lame's mu and lambda, so that small strains obey E and nu. Finite for every F; it does not
/// resist strong compression.
class StVenantKirchhoff : public LibraryMaterial<StVenantKirchhoff> {
 public:
  static constexpr const char *name = "st_venant_kirchhoff";

  explicit StVenantKirchhoff(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()), lambda_(parameters.constants.lambda()) {}

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    Real squares = Real(0.0);  // of the entries of 2 E
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const Real product = F(0, i) * F(0, j) + F(1, i) * F(1, j) + F(2, i) * F(2, j);
        const Real strain = product - (i == j ? 1.0 : 0.0);
        squares = squares + strain * strain;
      }
    }
    const Real trace = squared_norm(F) - 3.0;  // of 2 E
    return 0.25 * mu_ * squares + 0.125 * lambda_ * trace * trace;
  }

  /// P = F (2 mu E + lambda tr E I) = mu (F F'F - F) + lambda/2 (F:F - 3) F.
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    Matrix3<Real> P = cube(F);
    const Real factor = 0.5 * lambda_ * (squared_norm(F) - 3.0) - mu_;
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = mu_ * P.entries[k] + factor * F.entries[k];
    return P;
  }

  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    set_square(lambda_, F, A);
    add_identity(0.5 * lambda_ * (squared_norm(F) - 3.0) - mu_, A);
    add_cube_derivative(mu_, F, A);
  }

 private:
  double mu_, lambda_;
};

static_assert(SceneMaterial<StVenantKirchhoff>);

}  // namespace trefoil
