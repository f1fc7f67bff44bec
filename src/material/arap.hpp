#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/split_material.hpp"

namespace trefoil {

/// The as-rigid-as-possible energy (Sorkine and Alexa 2007) of a solid, with a volume term:
///   psi(F) = mu (F - R):(F - R) + kappa/2 (J - 1)^2,
/// R the proper rotation of F (see rotation_of()), J = det F. Finite for every F.
///
/// Small strains obey Lame's mu, and lambda = kappa: kappa is Lame's lambda unless it is given.
/// Volumetric: U(J) = kappa/2 (J - 1)^2.
///
/// Where the two smallest stretches of an inverted F add up to zero, R jumps: psi is continuous and
/// has a kink there. Below least_stretch_sum the tangent is kept from growing any further.
class Arap : public LibraryMaterial<Arap>, public SplitMaterial<Arap> {
 public:
  static constexpr const char *name = "arap";
  static constexpr bool has_volume_term = true;

  explicit Arap(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()),
        kappa_(parameters.volume_weight(name, parameters.constants.lambda())) {}

  [[nodiscard]] double mu() const { return mu_; }

  template <class Real>
  VolumetricLaw<Real> volumetric_law(const Real &J_minus_1) const {
    return quadratic_law(kappa_, J_minus_1);
  }

  /// W = mu |S - I|^2.
  template <class Real>
  Real distortional_energy(const Deformation<Real> &deformation) const {
    return mu_ * squared_norm(PolarDecomposition(deformation).biot_strain);
  }

  /// dW/dF = 2 mu (F - R) = 2 mu R (S - I): the derivative of R does not enter, since R is the
  /// nearest rotation.
  template <class Real>
  Matrix3<Real> stress_at_pressure(const Deformation<Real> &deformation, const Real &p) const {
    const PolarDecomposition<Real> polar(deformation);
    const Matrix3<Real> D = product(polar.rotation, polar.biot_strain), C = deformation.cofactor();
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = 2.0 * mu_ * D.entries[k] + p * C.entries[k];
    return P;
  }

  template <class Real>
  void add_tangent_at_pressure(const Deformation<Real> &deformation, const Real &p,
                               Tangent<Real> &A) const {
    const Matrix3<Real> F = deformation.F();
    add_identity(2.0 * mu_, A);
    add_rotation_derivative(Real(-2.0 * mu_), signed_svd(F), A);
    add_cofactor_derivative(p, F, A);
  }

 private:
  double mu_, kappa_;
};

static_assert(SceneMaterial<Arap> && VolumeSplittingMaterial<Arap>);

}  // namespace trefoil
