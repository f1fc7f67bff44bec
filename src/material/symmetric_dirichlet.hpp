#pragma once

#include <limits>

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/volume_term.hpp"

namespace trefoil {

/// The symmetric Dirichlet energy (Smith and Schaefer 2015, "Bijective parameterization with free
/// boundaries") of a solid, with a volume term:
///   psi(F) = mu/4 (F:F + F^-1:F^-1 - 6) + kappa/2 (J - 1)^2,   J = det F.
/// psi is +infinity at J <= 0, where stress and tangent mean nothing.
///
/// Small strains obey Lame's mu, and lambda = kappa: kappa is Lame's lambda unless it is given.
class SymmetricDirichlet : public LibraryMaterial<SymmetricDirichlet> {
 public:
  static constexpr const char *name = "symmetric_dirichlet";
  static constexpr bool has_volume_term = true;

  explicit SymmetricDirichlet(const MaterialParameters &parameters)
      : weight_(0.25 * parameters.constants.mu()),
        volume_(parameters.volume_weight(name, parameters.constants.lambda())) {}

  /// F^-1:F^-1 = I2 / J^2 with I2 = cof F : cof F.
  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    const Real J = determinant(F), inverse = squared_norm(cofactor(F)) / (J * J);
    return select(J <= Real(0.0), Real(std::numeric_limits<double>::infinity()),
                  weight_ * (squared_norm(F) + inverse - 6.0) + volume_.energy_density(F));
  }

  /// d(I2 / J^2)/dF = dI2/dF / J^2 - 2 I2 / J^3 cof F,  dI2/dF = 2 (I1 F - F F'F).
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    const Matrix3<Real> C = cofactor(F);
    const Real over_J = 1.0 / determinant(F), over_J2 = over_J * over_J;
    const Real of_C = -2.0 * squared_norm(C) * over_J2 * over_J;
    const Matrix3<Real> D = second_invariant_derivative(F);
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] = weight_ * (2.0 * F.entries[k] + over_J2 * D.entries[k] + of_C * C.entries[k]);
    }
    volume_.add_stress(F, P);
    return P;
  }

  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    const Matrix3<Real> C = cofactor(F);
    const Real over_J = 1.0 / determinant(F), over_J2 = over_J * over_J;
    const Real over_J3 = over_J2 * over_J, I2 = squared_norm(C);
    set_square(4.0 * weight_ * over_J2, F, A);
    add_identity(2.0 * weight_ * (1.0 + squared_norm(F) * over_J2), A);
    add_cube_derivative(-2.0 * weight_ * over_J2, F, A);
    add_product(-2.0 * weight_ * over_J3, second_invariant_derivative(F), C, A);
    add_square(6.0 * weight_ * I2 * over_J3 * over_J, C, A);
    add_cofactor_derivative(-2.0 * weight_ * I2 * over_J3, F, A);
    volume_.add_tangent(F, A);
  }

 private:
  template <class Real>
  static Matrix3<Real> second_invariant_derivative(const Matrix3<Real> &F) {
    Matrix3<Real> D = cube(F);
    const Real I1 = squared_norm(F);
    for (std::size_t k = 0; k < 9; ++k) D.entries[k] = 2.0 * (I1 * F.entries[k] - D.entries[k]);
    return D;
  }

  double weight_;
  VolumeTerm volume_;
};

static_assert(SceneMaterial<SymmetricDirichlet>);

}  // namespace trefoil
