#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// Corotated linear elasticity: Hooke's law for what is left of F without its rotation,
///   psi(F) = mu (F - R):(F - R) + lambda/2 (R:F - 3)^2,
/// R the proper rotation of F (see rotation_of()), with Lame's mu and lambda, so that small strains
/// obey E and nu. Finite for every F, and an inverted element costs little. Of R's jumps see Arap.
/// No part of it depends on J alone.
class Corotated : public LibraryMaterial<Corotated> {
 public:
  static constexpr const char *name = "corotated";

  explicit Corotated(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()), lambda_(parameters.constants.lambda()) {}

  /// In the Biot strain S - I, where F = R S: mu |S - I|^2 + lambda/2 tr^2(S - I).
  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    const Matrix3<Real> strain = PolarDecomposition(deformation).biot_strain;
    const Real trace = trace_of(strain);
    return mu_ * squared_norm(strain) + 0.5 * lambda_ * trace * trace;
  }

  /// P = R (2 mu (S - I) + lambda tr(S - I) I), for R:dR = 0 and F:dR = 0.
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    const PolarDecomposition<Real> polar(deformation);
    const Real pressure = lambda_ * trace_of(polar.biot_strain);
    Matrix3<Real> T = polar.biot_strain;
    for (Real &entry : T.entries) entry = 2.0 * mu_ * entry;
    for (int i = 0; i < 3; ++i) T(i, i) = T(i, i) + pressure;
    return product(polar.rotation, T);
  }

  /// dP/dF = 2 mu I + lambda R (x) R + (lambda (R:F - 3) - 2 mu) dR/dF.
  template <class Real>
  void tangent(const Deformation<Real> &deformation, Tangent<Real> &A) const {
    const SignedSvd<Real> svd = signed_svd(deformation.F());
    const Real trace = svd.stretch[0] + svd.stretch[1] + svd.stretch[2] - 3.0;
    set_square(lambda_, rotation_of(svd), A);
    add_identity(2.0 * mu_, A);
    add_rotation_derivative(lambda_ * trace - 2.0 * mu_, svd, A);
  }

 private:
  template <class Real>
  static Real trace_of(const Matrix3<Real> &strain) {
    return strain(0, 0) + strain(1, 1) + strain(2, 2);
  }

  double mu_, lambda_;
};

static_assert(SceneMaterial<Corotated>);

}  // namespace trefoil
