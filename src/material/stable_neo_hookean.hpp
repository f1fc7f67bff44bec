#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/split_material.hpp"

namespace trefoil {

/// Stable Neo-Hookean energy without the logarithmic barrier (Smith, de Goes, Kim 2018, "Stable
/// Neo-Hookean flesh simulation", equation 13 less its regularised origin barrier):
///   psi(F) = mu/2 (F:F - 3) + lambda/2 (J - alpha)^2,   J = det F,  alpha = 1 + mu/lambda.
/// Finite for every F, inverted ones included. At rest psi(I) = mu^2 / (2 lambda), P(I) = 0.
///
/// Volumetric: U(J) = lambda/2 (J - 1)^2; W = mu/2 (F:F - 3) - mu (J - 1).
class StableNeoHookean : public LibraryMaterial<StableNeoHookean>,
                         public SplitMaterial<StableNeoHookean> {
 public:
  static constexpr const char *name = "stable_neo_hookean";
  static constexpr bool has_raw_constants = true;
  using Lame = trefoil::Lame;

  StableNeoHookean(const ElasticConstants &constants, Lame lame)
      : mu_(constants.mu()),
        lambda_(constants.lambda() + (lame == Lame::physical ? constants.mu() : 0)) {}
  explicit StableNeoHookean(const MaterialParameters &parameters)
      : StableNeoHookean(parameters.constants, parameters.lame) {}

  [[nodiscard]] double mu() const { return mu_; }
  [[nodiscard]] double lambda() const { return lambda_; }
  /// psi(I), which energy_density() leaves out.
  [[nodiscard]] double rest_energy_density() const { return mu_ * mu_ / (2 * lambda_); }

  template <class Real>
  VolumetricLaw<Real> volumetric_law(const Real &J_minus_1) const {
    return quadratic_law(lambda_, J_minus_1);
  }

  template <class Real>
  Real distortional_energy(const Deformation<Real> &deformation) const {
    return distortional_energy(deformation.invariants());
  }
  template <class Real>
  Real distortional_energy(const Invariants<Real> &invariants) const {
    return 0.5 * mu_ * invariants.distortion;
  }

  /// mu (F - cof F) + p cof F.
  template <class Real>
  Matrix3<Real> stress_at_pressure(const Deformation<Real> &deformation, const Real &p) const {
    const Matrix3<Real> D = deformation.F_minus_cofactor(), C = deformation.cofactor();
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = mu_ * D.entries[k] + p * C.entries[k];
    return P;
  }

  template <class Real>
  void add_tangent_at_pressure(const Deformation<Real> &deformation, const Real &p,
                               Tangent<Real> &A) const {
    add_identity(mu_, A);
    add_cofactor_derivative(p - mu_, deformation.F(), A);
  }

 private:
  double mu_, lambda_;
};

static_assert(SceneMaterial<StableNeoHookean> && VolumeSplittingMaterial<StableNeoHookean>);

}  // namespace trefoil
