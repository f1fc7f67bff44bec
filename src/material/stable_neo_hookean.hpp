#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// Stable Neo-Hookean energy without the logarithmic barrier (Smith, de Goes, Kim 2018, "Stable
/// Neo-Hookean flesh simulation", equation 13 less its regularised origin barrier):
///   psi(F) = mu/2 (F:F - 3) + lambda/2 (J - alpha)^2,   J = det F,  alpha = 1 + mu/lambda.
/// Finite for every F, inverted ones included. At rest psi(I) = mu^2 / (2 lambda), P(I) = 0.
class StableNeoHookean : public LibraryMaterial<StableNeoHookean> {
 public:
  static constexpr const char *name = "stable_neo_hookean";
  static constexpr bool has_raw_constants = true;
  using Lame = trefoil::Lame;

  StableNeoHookean(const ElasticConstants &constants, Lame lame)
      : mu_(constants.mu()),
        lambda_(constants.lambda() + (lame == Lame::physical ? constants.mu() : 0)),
        alpha_(1 + mu_ / lambda_) {}
  explicit StableNeoHookean(const MaterialParameters &parameters)
      : StableNeoHookean(parameters.constants, parameters.lame) {}

  [[nodiscard]] double mu() const { return mu_; }
  [[nodiscard]] double lambda() const { return lambda_; }

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    const Real volume_change = determinant(F) - alpha_;
    return 0.5 * mu_ * (squared_norm(F) - 3.0) + 0.5 * lambda_ * volume_change * volume_change;
  }

  /// P = mu F + lambda (J - alpha) cof F.
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    const Real pressure = lambda_ * (determinant(F) - alpha_);
    Matrix3<Real> P = cofactor(F);
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = mu_ * F.entries[k] + pressure * P.entries[k];
    return P;
  }

  /// dP/dF = mu I + lambda cof F (x) cof F + lambda (J - alpha) d(cof F)/dF.
  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    set_square(lambda_, cofactor(F), A);
    add_identity(mu_, A);
    add_cofactor_derivative(lambda_ * (determinant(F) - alpha_), F, A);
  }

 private:
  double mu_, lambda_, alpha_;
};

static_assert(SceneMaterial<StableNeoHookean>);

}  // namespace trefoil
