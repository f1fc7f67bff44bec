#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// Corotated linear elasticity: Hooke's law for what is left of F without its rotation,
///   psi(F) = mu (F - R):(F - R) + lambda/2 (R:F - 3)^2,
/// R the proper rotation of F (see rotation_of()), with Lame's mu and lambda, so that small strains
/// obey E and nu. Finite for every F, and an inverted element costs little. Of R's jumps see Arap.
class Corotated : public LibraryMaterial<Corotated> {
 public:
  static constexpr const char *name = "corotated";

  explicit Corotated(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()), lambda_(parameters.constants.lambda()) {}

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    Real squares = Real(0.0), trace = Real(0.0);
    for (const Real &stretch : signed_svd(F).stretch) {
      squares = squares + (stretch - 1.0) * (stretch - 1.0);
      trace = trace + (stretch - 1.0);
    }
    return mu_ * squares + 0.5 * lambda_ * trace * trace;
  }

  /// P = 2 mu (F - R) + lambda (R:F - 3) R, for R:dR = 0 and F:dR = 0.
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    const SignedSvd<Real> svd = signed_svd(F);
    const Real factor = lambda_ * trace_of_strain(svd) - 2.0 * mu_;
    Matrix3<Real> P = rotation_of(svd);
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] = 2.0 * mu_ * F.entries[k] + factor * P.entries[k];
    }
    return P;
  }

  /// dP/dF = 2 mu I + lambda R (x) R + (lambda (R:F - 3) - 2 mu) dR/dF.
  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    const SignedSvd<Real> svd = signed_svd(F);
    set_square(lambda_, rotation_of(svd), A);
    add_identity(2.0 * mu_, A);
    add_rotation_derivative(lambda_ * trace_of_strain(svd) - 2.0 * mu_, svd, A);
  }

 private:
  template <class Real>
  static Real trace_of_strain(const SignedSvd<Real> &svd) {
    return (svd.stretch[0] - 1.0) + (svd.stretch[1] - 1.0) + (svd.stretch[2] - 1.0);
  }

  double mu_, lambda_;
};

static_assert(SceneMaterial<Corotated>);

}  // namespace trefoil
