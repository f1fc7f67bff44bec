#pragma once

#include <limits>

#include "material/library_material.hpp"
#include "trefoil/log1pmx.hpp"
#include "trefoil/material.hpp"
#include "trefoil/split_material.hpp"

namespace trefoil {

/// The compressible Neo-Hookean energy (Bonet and Wood, "Nonlinear continuum mechanics for finite
/// element analysis", section 6.4.3):
///   psi(F) = mu/2 (F:F - 3) - mu log J + lambda/2 (log J)^2,   J = det F,
/// with Lame's mu and lambda, so that small strains obey E and nu. psi is +infinity at J <= 0,
/// where stress and tangent mean nothing.
///
/// Volumetric: U(J) = lambda/2 (log J)^2. -mu log J, whose weight does not grow with Poisson's
/// ratio and which balances F:F at rest, is in W = mu/2 (F:F - 3) - mu log J.
class NeoHookean : public LibraryMaterial<NeoHookean>, public SplitMaterial<NeoHookean> {
 public:
  static constexpr const char *name = "neo_hookean";

  explicit NeoHookean(const MaterialParameters &parameters)
      : mu_(parameters.constants.mu()), lambda_(parameters.nonnegative_lambda(name)) {}

  [[nodiscard]] double mu() const { return mu_; }

  /// U' = lambda log J / J, U'' = lambda (1 - log J) / J^2.
  template <class Real>
  VolumetricLaw<Real> volumetric_law(const Real &J_minus_1) const {
    const Real log_J = logarithm(J_minus_1).log1p, over_J = 1.0 / (1.0 + J_minus_1);
    return {select(J_minus_1 <= Real(-1.0), Real(std::numeric_limits<double>::infinity()),
                   0.5 * lambda_ * log_J * log_J),
            lambda_ * log_J * over_J, lambda_ * (1.0 - log_J) * over_J * over_J};
  }

  /// (F:F - 3)/2 - log J = ((F:F - 3)/2 - (J - 1)) - (log J - (J - 1)): at small strains the parts
  /// are of second order, at large ones J itself would drown them.
  template <class Real>
  Real distortional_energy(const Deformation<Real> &deformation) const {
    constexpr double small = 0.5;
    const Real J_minus_1 = deformation.J_minus_1();
    const auto [log_J, difference] = logarithm(J_minus_1);
    const Real balanced =
        select(abs(J_minus_1) < Real(small), 0.5 * deformation.I1_distortion() - difference,
               0.5 * deformation.I1_minus_3() - log_J);
    return select(deformation.J() <= Real(0.0), Real(std::numeric_limits<double>::infinity()),
                  mu_ * balanced);
  }

  /// The same in its balanced parts alone.
  template <class Real>
  Real distortional_energy(const Invariants<Real> &invariants) const {
    return select(invariants.J_minus_1 <= Real(-1.0), Real(std::numeric_limits<double>::infinity()),
                  mu_ * (0.5 * invariants.distortion - logarithm(invariants.J_minus_1).log1pmx));
  }

  /// mu (F - F^-T) + p cof F.
  template <class Real>
  Matrix3<Real> stress_at_pressure(const Deformation<Real> &deformation, const Real &p) const {
    const Matrix3<Real> L = deformation.inverse_transpose_minus_identity(),
                        C = deformation.cofactor(), &H = deformation.H();
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] = mu_ * (H.entries[k] - L.entries[k]) + p * C.entries[k];
    }
    return P;
  }

  /// mu I + mu / J^2 cof F (x) cof F + (p - mu / J) d(cof F)/dF.
  template <class Real>
  void add_tangent_at_pressure(const Deformation<Real> &deformation, const Real &p,
                               Tangent<Real> &A) const {
    const Real mu_over_J = mu_ / deformation.J();
    add_square(mu_over_J / deformation.J(), deformation.cofactor(), A);
    add_identity(mu_, A);
    add_cofactor_derivative(p - mu_over_J, deformation.F(), A);
  }

 private:
  double mu_, lambda_;
};

static_assert(SceneMaterial<NeoHookean> && VolumeSplittingMaterial<NeoHookean>);

}  // namespace trefoil
