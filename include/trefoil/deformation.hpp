#pragma once

#include "trefoil/branch_free.hpp"
#include "trefoil/matrix3.hpp"

namespace trefoil {

/// What an isotropic energy may depend on, each zero at rest and with all its digits at small
/// strains, see Deformation.
template <class Real>
struct Invariants {
  Real distortion;        ///< (I1 - 3) - 2 (J - 1), I1 = F:F
  Real second_of_strain;  ///< tr cof E of Green's strain; I2 - 3 is 2 (I1 - 3) + 4 tr cof E
  Real J_minus_1;         ///< J = det F

  [[nodiscard]] Real I1_minus_3() const { return distortion + 2.0 * J_minus_1; }
  /// (I2 - 3) - 4 (J - 1), I2 = cof F : cof F.
  [[nodiscard]] Real I2_distortion() const { return 2.0 * distortion + 4.0 * second_of_strain; }
};

/// How a body is deformed at a point, by the gradient H of its displacement: F = I + H.
///
/// At small strains the digits are in H. Where the formula of an energy has a difference of numbers
/// of order one (F:F - 3, J - 1, F - F^-T), what stands here in its place has no such difference,
/// and is right to rounding however small H is. Terms that balance each other at rest must do so in
/// the formula: (I1 - 3) - 2 (J - 1) is of second order in H, its summands are of first. A body
/// that is turned as a whole has an H that is not small, and a small Green strain E, of which what
/// is said of H holds as well.
template <class Real>
class Deformation {
 public:
  explicit Deformation(const Matrix3<Real> &displacement_gradient)
      : H_(displacement_gradient),
        cofactor_(trefoil::cofactor(H_)),
        trace_(H_(0, 0) + H_(1, 1) + H_(2, 2)),
        second_(cofactor_(0, 0) + cofactor_(1, 1) + cofactor_(2, 2)),
        third_(H_(0, 0) * cofactor_(0, 0) + H_(0, 1) * cofactor_(0, 1) +
               H_(0, 2) * cofactor_(0, 2)) {}

  /// The displacement gradient H = F - I.
  [[nodiscard]] const Matrix3<Real> &H() const { return H_; }
  /// The deformation gradient.
  [[nodiscard]] Matrix3<Real> F() const {
    Matrix3<Real> F = H_;
    for (int i = 0; i < 3; ++i) F(i, i) = F(i, i) + 1.0;
    return F;
  }

  /// The invariants of H: tr H, tr cof H and det H.
  [[nodiscard]] const Real &trace_of_H() const { return trace_; }
  [[nodiscard]] const Real &second_invariant_of_H() const { return second_; }
  [[nodiscard]] const Real &det_H() const { return third_; }

  /// J = det F, and J - 1 = tr H + tr cof H + det H.
  [[nodiscard]] Real J() const { return 1.0 + J_minus_1(); }
  [[nodiscard]] Real J_minus_1() const { return trace_ + (second_ + third_); }

  /// cof F = dJ/dF, and cof F - I = tr(H) I - H' + cof H.
  [[nodiscard]] Matrix3<Real> cofactor() const {
    Matrix3<Real> C = cofactor_minus_identity();
    for (int i = 0; i < 3; ++i) C(i, i) = C(i, i) + 1.0;
    return C;
  }
  [[nodiscard]] Matrix3<Real> cofactor_minus_identity() const {
    Matrix3<Real> K;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) K(i, j) = cofactor_(i, j) - H_(j, i);
      K(i, i) = K(i, i) + trace_;
    }
    return K;
  }

  /// F^-T - I = (cof F - I - (J - 1) I) / J, for J != 0.
  [[nodiscard]] Matrix3<Real> inverse_transpose_minus_identity() const {
    const Real over_J = 1.0 / J(), change = J_minus_1();
    Matrix3<Real> L = cofactor_minus_identity();
    for (int i = 0; i < 3; ++i) L(i, i) = L(i, i) - change;
    for (Real &entry : L.entries) entry = entry * over_J;
    return L;
  }

  /// I1 - 3 with I1 = F:F, which is 2 tr H + H:H.
  [[nodiscard]] Real I1_minus_3() const { return 2.0 * trace_ + squared_norm(H_); }
  /// I2 - 3 with I2 = cof F : cof F.
  [[nodiscard]] Real I2_minus_3() const {
    return 4.0 * trace_ + 2.0 * second_ + squared_norm(cofactor_minus_identity());
  }
  /// (I1 - 3) - 2 (J - 1), whose derivative is 2 (F - cof F).
  ///
  /// It is H:H - 2 tr cof H - 2 det H; and, since J^2 = det(I + 2 E) = 1 + y + x with y = I1 - 3 =
  /// 2 tr E and x = 4 tr cof E + 8 det E, it is (y (J - 1) - 2 x) / (J + 1).
  [[nodiscard]] Real I1_distortion() const {
    const Real by_gradient = squared_norm(H_) - 2.0 * (second_ + third_);
    const StrainInvariants E = strain_invariants();
    const Real by_strain = 2.0 * (E.trace * J_minus_1() - E.of_J2()) / (2.0 + J_minus_1());
    return select(E.serve, by_strain, by_gradient);
  }
  /// (I2 - 3) - 4 (J - 1), whose derivative is 4 (F - cof F) + 4 F (tr(E) I - E).
  /// I2 - 3 is 2 (I1 - 3) + 4 tr cof E.
  [[nodiscard]] Real I2_distortion() const { return invariants().I2_distortion(); }
  [[nodiscard]] Invariants<Real> invariants() const {
    return {I1_distortion(), strain_invariants().second, J_minus_1()};
  }
  /// F - cof F.
  [[nodiscard]] Matrix3<Real> F_minus_cofactor() const {
    Matrix3<Real> D = cofactor_minus_identity();
    for (std::size_t k = 0; k < 9; ++k) D.entries[k] = H_.entries[k] - D.entries[k];
    return D;
  }

  /// Green's strain E = (F'F - I)/2 = (H + H' + H'H)/2.
  [[nodiscard]] Matrix3<Real> green_strain() const {
    Matrix3<Real> E;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        const Real product = H_(0, i) * H_(0, j) + H_(1, i) * H_(1, j) + H_(2, i) * H_(2, j);
        E(i, j) = 0.5 * (H_(i, j) + H_(j, i) + product);
        E(j, i) = E(i, j);
      }
    }
    return E;
  }

  /// The invariants of Green's strain: tr E, tr cof E, det E.
  struct StrainInvariants {
    Real trace, second, third;
    /// Where they tell more than H: at small strains, and where F is no reflection.
    decltype(Real() < Real()) serve;

    /// J^2 - 1 less its part 2 tr E of first order.
    [[nodiscard]] Real of_J2() const { return 4.0 * second + 8.0 * third; }
  };
  [[nodiscard]] StrainInvariants strain_invariants() const {
    constexpr double largest = 0.25;  // J^2 has no digits where F is nearly singular
    const Matrix3<Real> E = green_strain(), C = trefoil::cofactor(E);
    const decltype(Real() < Real()) serve((squared_norm(E) < Real(largest * largest)) &
                                          (J() > Real(0.0)));
    return {E(0, 0) + E(1, 1) + E(2, 2), C(0, 0) + C(1, 1) + C(2, 2),
            E(0, 0) * C(0, 0) + E(0, 1) * C(0, 1) + E(0, 2) * C(0, 2), serve};
  }

 private:
  Matrix3<Real> H_, cofactor_;  ///< and cof H
  Real trace_, second_, third_;
};

/// The Cauchy stress sigma = P F' / J, force per deformed area, of P = dpsi/dF.
template <class Real>
Matrix3<Real> cauchy_stress(const Deformation<Real> &deformation, const Matrix3<Real> &P) {
  const Matrix3<Real> F = deformation.F();
  const Real J = deformation.J();
  Matrix3<Real> sigma;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      sigma(i, j) = (P(i, 0) * F(j, 0) + P(i, 1) * F(j, 1) + P(i, 2) * F(j, 2)) / J;
    }
  }
  return sigma;
}

}  // namespace trefoil
