#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/volume_term.hpp"

namespace trefoil {

/// The as-rigid-as-possible energy (Sorkine and Alexa 2007) of a solid, with a volume term:
///   psi(F) = mu (F - R):(F - R) + kappa/2 (J - 1)^2,
/// R the proper rotation of F (see rotation_of()), J = det F. Finite for every F.
///
/// Small strains obey Lame's mu, and lambda = kappa: kappa is Lame's lambda unless it is given.
///
/// Where the two smallest stretches of an inverted F add up to zero, R jumps: psi is continuous and
/// has a kink there. Below least_stretch_sum the tangent is kept from growing any further.
class Arap : public LibraryMaterial<Arap> {
 public:
  static constexpr const char *name = "arap";
  static constexpr bool has_volume_term = true;

  explicit Arap(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()),
        volume_(parameters.volume_weight(name, parameters.constants.lambda())) {}

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    Real sum = Real(0.0);
    for (const Real &stretch : signed_svd(F).stretch) {
      sum = sum + (stretch - 1.0) * (stretch - 1.0);
    }
    return mu_ * sum + volume_.energy_density(F);
  }

  /// P = 2 mu (F - R) and what the volume adds: the derivative of R does not enter, since R is the
  /// nearest rotation.
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    Matrix3<Real> P = rotation_of(F);
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = 2.0 * mu_ * (F.entries[k] - P.entries[k]);
    volume_.add_stress(F, P);
    return P;
  }

  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    A.fill(Real(0.0));
    add_identity(2.0 * mu_, A);
    add_rotation_derivative(Real(-2.0 * mu_), signed_svd(F), A);
    volume_.add_tangent(F, A);
  }

 private:
  double mu_;
  VolumeTerm volume_;
};

static_assert(SceneMaterial<Arap>);

}  // namespace trefoil
