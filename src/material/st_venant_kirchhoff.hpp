#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// Saint Venant's and Kirchhoff's energy, Hooke's law for Green's strain E = (F'F - I)/2:
///   psi(F) = mu E:E + lambda/2 (tr E)^2,
/// with Lame's mu and lambda, so that small strains obey E and nu. Finite for every F; it does not
/// resist strong compression. No part of it depends on J alone.
class StVenantKirchhoff : public LibraryMaterial<StVenantKirchhoff> {
 public:
  static constexpr const char *name = "st_venant_kirchhoff";

  explicit StVenantKirchhoff(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()), lambda_(parameters.constants.lambda()) {}

  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    const Matrix3<Real> E = deformation.green_strain();
    const Real trace = E(0, 0) + E(1, 1) + E(2, 2);
    return mu_ * squared_norm(E) + 0.5 * lambda_ * trace * trace;
  }

  /// P = F (2 mu E + lambda tr E I).
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    Matrix3<Real> S = deformation.green_strain();
    const Real pressure = lambda_ * (S(0, 0) + S(1, 1) + S(2, 2));
    for (Real &entry : S.entries) entry = 2.0 * mu_ * entry;
    for (int i = 0; i < 3; ++i) S(i, i) = S(i, i) + pressure;
    return product(deformation.F(), S);
  }

  /// From P = mu (F F'F - F) + lambda/2 (F:F - 3) F.
  template <class Real>
  void tangent(const Deformation<Real> &deformation, Tangent<Real> &A) const {
    const Matrix3<Real> F = deformation.F();
    set_square(lambda_, F, A);
    add_identity(0.5 * lambda_ * deformation.I1_minus_3() - mu_, A);
    add_cube_derivative(mu_, F, A);
  }

 private:
  double mu_, lambda_;
};

static_assert(SceneMaterial<StVenantKirchhoff>);

}  // namespace trefoil
