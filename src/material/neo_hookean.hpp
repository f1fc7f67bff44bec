#pragma once

#include <limits>

#include "material/library_material.hpp"
#include "trefoil/log1pmx.hpp"
#include "trefoil/material.hpp"

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

  /// (F:F - 3)/2 - log J = ((F:F - 3)/2 - (J - 1)) - (log J - (J - 1)): at small strains the parts
  /// are of second order, at large ones J itself would drown them.
  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    constexpr double small = 0.5;
    const Real J_minus_1 = deformation.J_minus_1();
    const auto [log_J, difference] = logarithm(J_minus_1);
    const Real balanced =
        select(abs(J_minus_1) < Real(small), 0.5 * deformation.I1_distortion() - difference,
               0.5 * deformation.I1_minus_3() - log_J);
    return select(deformation.J() <= Real(0.0), Real(std::numeric_limits<double>::infinity()),
                  mu_ * balanced + 0.5 * lambda_ * log_J * log_J);
  }

  /// The same in its balanced parts alone.
  template <class Real>
  Real energy_of_invariants(const Invariants<Real> &invariants) const {
    const auto [log_J, difference] = logarithm(invariants.J_minus_1);
    return select(invariants.J_minus_1 <= Real(-1.0), Real(std::numeric_limits<double>::infinity()),
                  mu_ * (0.5 * invariants.distortion - difference) + 0.5 * lambda_ * log_J * log_J);
  }

  /// P = mu (F - F^-T) + lambda log J F^-T.
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    const Matrix3<Real> L = deformation.inverse_transpose_minus_identity(), &H = deformation.H();
    const Real pressure = lambda_ * logarithm(deformation.J_minus_1()).log1p;
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] = mu_ * (H.entries[k] - L.entries[k]) + pressure * L.entries[k];
    }
    for (int i = 0; i < 3; ++i) P(i, i) = P(i, i) + pressure;
    return P;
  }

  /// dP/dF = mu I + (lambda - (lambda log J - mu)) / J^2 cof F (x) cof F
  ///         + (lambda log J - mu) / J d(cof F)/dF.
  template <class Real>
  void tangent(const Deformation<Real> &deformation, Tangent<Real> &A) const {
    const Real J = deformation.J();
    const Real slope = lambda_ * logarithm(deformation.J_minus_1()).log1p - mu_;
    set_square((lambda_ - slope) / (J * J), deformation.cofactor(), A);
    add_identity(mu_, A);
    add_cofactor_derivative(slope / J, deformation.F(), A);
  }

 private:
  double mu_, lambda_;
};

static_assert(SceneMaterial<NeoHookean>);

}  // namespace trefoil
