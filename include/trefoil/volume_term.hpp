#pragma once

#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// The energy kappa/2 (J - 1)^2 - tension (J - 1), J = det F, which other energies take along: it
/// keeps the volume. With a tension it also balances a stress `tension` I of theirs at rest.
class VolumeTerm {
 public:
  explicit VolumeTerm(double kappa, double tension = 0) : kappa_(kappa), tension_(tension) {}

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    const Real change = determinant(F) - 1.0;
    return (0.5 * kappa_ * change - tension_) * change;
  }

  /// Adds (kappa (J - 1) - tension) cof F.
  template <class Real>
  void add_stress(const Matrix3<Real> &F, Matrix3<Real> &P) const {
    const Real pressure = kappa_ * (determinant(F) - 1.0) - tension_;
    const Matrix3<Real> C = cofactor(F);
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = P.entries[k] + pressure * C.entries[k];
  }

  template <class Real>
  void add_tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    const Real pressure = kappa_ * (determinant(F) - 1.0) - tension_;
    add_square(kappa_, cofactor(F), A);
    add_cofactor_derivative(pressure, F, A);
  }

 private:
  double kappa_, tension_;
};

}  // namespace trefoil
