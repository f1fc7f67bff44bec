#pragma once

#include <limits>

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// The compressible Neo-Hookean energy (Bonet and Wood, "Nonlinear continuum mechanics for finite
/// element analysis", section 6.4.3):
///   psi(F) = mu/2 (F:F - 3) - mu log J + lambda/2 (log J)^2,   J = det F,
/// with Lame's mu and lambda, so that small strains obey E and nu. psi is +infinity at J <= 0,
/// where stress and tangent mean nothing.
class NeoHookean : public LibraryMaterial<NeoHookean> {
 public:
  static constexpr const char *name = "neo_hookean";

  explicit NeoHookean(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()), lambda_(parameters.nonnegative_lambda(name)) {}

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    const Real J = determinant(F), log_J = log(J);
    return select(J <= Real(0.0), Real(std::numeric_limits<double>::infinity()),
                  0.5 * mu_ * (squared_norm(F) - 3.0) + (0.5 * lambda_ * log_J - mu_) * log_J);
  }

  /// P = mu F + (lambda log J - mu) F^-T,  F^-T = cof F / J.
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    const Real J = determinant(F), pressure = (lambda_ * log(J) - mu_) / J;
    Matrix3<Real> P = cofactor(F);
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = mu_ * F.entries[k] + pressure * P.entries[k];
    return P;
  }

  /// dP/dF = mu I + (lambda - (lambda log J - mu)) / J^2 cof F (x) cof F
  ///         + (lambda log J - mu) / J d(cof F)/dF.
  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    const Real J = determinant(F), slope = lambda_ * log(J) - mu_;
    set_square((lambda_ - slope) / (J * J), cofactor(F), A);
    add_identity(mu_, A);
    add_cofactor_derivative(slope / J, F, A);
  }

 private:
  double mu_, lambda_;
};

static_assert(SceneMaterial<NeoHookean>);

}  // namespace trefoil
