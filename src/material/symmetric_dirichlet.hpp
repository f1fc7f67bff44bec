#pragma once

#include <limits>

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/split_material.hpp"

namespace trefoil {

/// The symmetric Dirichlet energy (Smith and Schaefer 2015, "Bijective parameterization with free
/// boundaries") of a solid, with a volume term:
///   psi(F) = mu/4 (F:F + F^-1:F^-1 - 6) + kappa/2 (J - 1)^2,   J = det F.
/// psi is +infinity at J <= 0, where stress and tangent mean nothing.
///
/// Small strains obey Lame's mu, and lambda = kappa: kappa is Lame's lambda unless it is given.
/// Volumetric: U(J) = kappa/2 (J - 1)^2.
class SymmetricDirichlet : public LibraryMaterial<SymmetricDirichlet>,
                           public SplitMaterial<SymmetricDirichlet> {
 public:
  static constexpr const char *name = "symmetric_dirichlet";
  static constexpr bool has_volume_term = true;

  explicit SymmetricDirichlet(const MaterialParameters &parameters)
      : weight_(0.25 * parameters.constants.mu()),
        kappa_(parameters.volume_weight(name, parameters.constants.lambda())) {}

  [[nodiscard]] double mu() const { return 4 * weight_; }

  template <class Real>
  VolumetricLaw<Real> volumetric_law(const Real &J_minus_1) const {
    return quadratic_law(kappa_, J_minus_1);
  }

  /// With Green's strain E and J^2 = det(I + 2 E), F:F - 3 = 2 tr E and
  /// F^-1:F^-1 - 3 = (-2 tr E - 8 tr cof E - 24 det E) / J^2: their sum is
  /// (2 tr E (J^2 - 1) - 8 tr cof E - 24 det E) / J^2, of second order.
  template <class Real>
  Real distortional_energy(const Deformation<Real> &deformation) const {
    const auto E = deformation.strain_invariants();
    const Real of_J2 = 2.0 * E.trace + E.of_J2();
    const Real by_strain =
        (2.0 * E.trace * of_J2 - 8.0 * E.second - 24.0 * E.third) / (1.0 + of_J2);
    const Real sum = select(E.serve, by_strain, by_inverse(deformation));
    return select(deformation.J() <= Real(0.0), Real(std::numeric_limits<double>::infinity()),
                  weight_ * sum);
  }

  /// With F^-1:F^-1 = I2 / J^2 and j = J - 1: F:F + F^-1:F^-1 - 6 is
  /// (I1 - 3 - 2 j) + (I2 - 3 - 4 j + j^2 + 2 j^3) / J^2.
  template <class Real>
  Real distortional_energy(const Invariants<Real> &invariants) const {
    const Real j = invariants.J_minus_1, J = 1.0 + j;
    const Real sum =
        invariants.distortion + (invariants.I2_distortion() + j * j * (1.0 + 2.0 * j)) / (J * J);
    return select(J <= Real(0.0), Real(std::numeric_limits<double>::infinity()), weight_ * sum);
  }

  /// dW/dF = mu/2 (F - B B'B) with B = F^-T = I + L. Of B B' = I + 2 M, 2 M = L + L' + L L', so
  /// F - B B'B = H - L - 2 M B.
  template <class Real>
  Matrix3<Real> stress_at_pressure(const Deformation<Real> &deformation, const Real &p) const {
    const Matrix3<Real> L = deformation.inverse_transpose_minus_identity(),
                        C = deformation.cofactor();
    Matrix3<Real> B = L, M;
    for (int i = 0; i < 3; ++i) {
      B(i, i) = B(i, i) + 1.0;
      for (int j = 0; j <= i; ++j) {
        M(i, j) = L(i, j) + L(j, i) + (L(i, 0) * L(j, 0) + L(i, 1) * L(j, 1) + L(i, 2) * L(j, 2));
        M(j, i) = M(i, j);
      }
    }
    const Matrix3<Real> MB = product(M, B), &H = deformation.H();
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] =
          2.0 * weight_ * (H.entries[k] - L.entries[k] - MB.entries[k]) + p * C.entries[k];
    }
    return P;
  }

  /// From F^-1:F^-1 = I2 / J^2 with I2 = cof F : cof F, dI2/dF = 2 (I1 F - F F'F), I1 = F:F.
  template <class Real>
  void add_tangent_at_pressure(const Deformation<Real> &deformation, const Real &p,
                               Tangent<Real> &A) const {
    const Matrix3<Real> F = deformation.F(), C = deformation.cofactor();
    const Real over_J = 1.0 / deformation.J(), over_J2 = over_J * over_J;
    const Real over_J3 = over_J2 * over_J, I1 = squared_norm(F), I2 = squared_norm(C);
    Matrix3<Real> D = cube(F);
    for (std::size_t k = 0; k < 9; ++k) D.entries[k] = 2.0 * (I1 * F.entries[k] - D.entries[k]);
    add_square(4.0 * weight_ * over_J2, F, A);
    add_identity(2.0 * weight_ * (1.0 + I1 * over_J2), A);
    add_cube_derivative(-2.0 * weight_ * over_J2, F, A);
    add_product(-2.0 * weight_ * over_J3, D, C, A);
    add_square(6.0 * weight_ * I2 * over_J3 * over_J, C, A);
    add_cofactor_derivative(p - 2.0 * weight_ * I2 * over_J3, F, A);
  }

 private:
  /// F:F + F^-1:F^-1 - 6 where strains are large. With L = F^-T - I it is H:H + L:L + 2 tr(H + L);
  /// the traces cancel to first order, J tr(H + L) = tr H (J - 1) - 2 tr cof H - 3 det H.
  template <class Real>
  static Real by_inverse(const Deformation<Real> &deformation) {
    const Real traces = deformation.trace_of_H() * deformation.J_minus_1() -
                        2.0 * deformation.second_invariant_of_H() - 3.0 * deformation.det_H();
    return squared_norm(deformation.H()) +
           squared_norm(deformation.inverse_transpose_minus_identity()) +
           2.0 * traces / deformation.J();
  }

  double weight_, kappa_;
};

static_assert(SceneMaterial<SymmetricDirichlet> && VolumeSplittingMaterial<SymmetricDirichlet>);

}  // namespace trefoil
