#pragma once

#include "trefoil/deformation.hpp"

namespace trefoil {

/// A point of a plane with the products of its coordinates that polynomials of degree 4 are made
/// of: a, b, a^2, ab, b^2, a^3, a^2 b, ..., b^4.
class PlanePoint {
 public:
  PlanePoint(double a, double b) : products_{a, b} {
    for (std::size_t first = 0, degree = 1; degree < 4; first += ++degree) {
      for (std::size_t k = 0; k <= degree; ++k) {
        products_[first + degree + 1 + k] = a * products_[first + k];
      }
      products_[first + 2 * degree + 2] = b * products_[first + degree];
    }
  }

  [[nodiscard]] double a() const { return products_[0]; }
  [[nodiscard]] double b() const { return products_[1]; }
  [[nodiscard]] const std::array<double, 14> &products() const { return products_; }

 private:
  std::array<double, 14> products_;
};

/// The coefficients of J = det(F + a D + b S) in the order of PlanePoint::products(), less the
/// constant one: those of degree 1 to 3.
template <class Real>
std::array<Real, 9> determinant_in_plane(const Deformation<Real> &deformation,
                                         const Matrix3<Real> &D, const Matrix3<Real> &S) {
  const Matrix3<Real> F = deformation.F(), C = deformation.cofactor(), of_D = cofactor(D),
                      of_S = cofactor(S);
  return {contraction(C, D),    contraction(C, S),
          contraction(F, of_D), contraction(F, mixed_cofactor(D, S)),
          contraction(F, of_S), determinant(D),
          contraction(of_D, S), contraction(D, of_S),
          determinant(S)};
}

/// The invariants of F = I + H + a D + b S: polynomials in a and b of degree 3 (J, distortion) and
/// 4. What is constant and what is linear keep their digits at small strains, as in Deformation; of
/// higher terms each is as good as the squares of D and S.
template <class Real>
class PlaneInvariants {
 public:
  PlaneInvariants(const Deformation<Real> &deformation, const Matrix3<Real> &D,
                  const Matrix3<Real> &S)
      : start_(deformation.invariants()), J_(determinant_in_plane(deformation, D, S)) {
    expand_distortion(deformation, D, S);
    expand_second_of_strain(deformation, D, S);
  }

  /// Those of F = I + H.
  [[nodiscard]] const Invariants<Real> &start() const { return start_; }

  [[nodiscard]] Invariants<Real> at(const PlanePoint &point) const {
    const auto &products = point.products();
    Invariants<Real> result = start_;
    Real cubic(0.0);
    for (std::size_t k = 0; k < 5; ++k) {
      result.J_minus_1 = result.J_minus_1 + products[k] * J_[k];
      result.distortion = result.distortion + products[k] * distortion_[k];
    }
    for (std::size_t k = 5; k < 9; ++k) cubic = cubic + products[k] * J_[k];
    result.J_minus_1 = result.J_minus_1 + cubic;
    result.distortion = result.distortion - 2.0 * cubic;
    for (std::size_t k = 0; k < 14; ++k) {
      result.second_of_strain = result.second_of_strain + products[k] * second_[k];
    }
    return result;
  }

 private:
  /// (F:F - 3) - 2 (J - 1), whose derivative is 2 (F - cof F), up to degree 2.
  void expand_distortion(const Deformation<Real> &deformation, const Matrix3<Real> &D,
                         const Matrix3<Real> &S) {
    const Matrix3<Real> slope = deformation.F_minus_cofactor();
    distortion_ = {2.0 * contraction(slope, D), 2.0 * contraction(slope, S),
                   squared_norm(D) - 2.0 * J_[2], 2.0 * contraction(D, S) - 2.0 * J_[3],
                   squared_norm(S) - 2.0 * J_[4]};
  }

  /// tr cof E of E = E_0 + a sym(F'D) + b sym(F'S) + a^2/2 D'D + ab sym(D'S) + b^2/2 S'S.
  void expand_second_of_strain(const Deformation<Real> &deformation, const Matrix3<Real> &D,
                               const Matrix3<Real> &S) {
    const Matrix3<Real> F = deformation.F(), zero = deformation.green_strain(), a = strain(F, D),
                        b = strain(F, S), ab = strain(D, S);
    // Twice the matrices of a^2 and b^2.
    const Matrix3<Real> aa = strain(D, D), bb = strain(S, S);
    second_ = {mixed_trace(zero, a),
               mixed_trace(zero, b),
               0.5 * (mixed_trace(a, a) + mixed_trace(zero, aa)),
               mixed_trace(a, b) + mixed_trace(zero, ab),
               0.5 * (mixed_trace(b, b) + mixed_trace(zero, bb)),
               0.5 * mixed_trace(a, aa),
               mixed_trace(a, ab) + 0.5 * mixed_trace(b, aa),
               mixed_trace(b, ab) + 0.5 * mixed_trace(a, bb),
               0.5 * mixed_trace(b, bb),
               0.125 * mixed_trace(aa, aa),
               0.5 * mixed_trace(aa, ab),
               0.5 * mixed_trace(ab, ab) + 0.25 * mixed_trace(aa, bb),
               0.5 * mixed_trace(ab, bb),
               0.125 * mixed_trace(bb, bb)};
  }

  /// sym(A'B).
  static Matrix3<Real> strain(const Matrix3<Real> &A, const Matrix3<Real> &B) {
    Matrix3<Real> E;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j) {
        Real sum = A(0, i) * B(0, j) + A(0, j) * B(0, i);
        for (int k = 1; k < 3; ++k) sum = sum + (A(k, i) * B(k, j) + A(k, j) * B(k, i));
        E(i, j) = 0.5 * sum;
        E(j, i) = E(i, j);
      }
    }
    return E;
  }

  /// The trace of mixed_cofactor(A, B) for symmetric matrices; that of cof A is half of (A, A)'s.
  static Real mixed_trace(const Matrix3<Real> &A, const Matrix3<Real> &B) {
    return A(0, 0) * (B(1, 1) + B(2, 2)) + A(1, 1) * (B(0, 0) + B(2, 2)) +
           A(2, 2) * (B(0, 0) + B(1, 1)) -
           2.0 * (A(0, 1) * B(0, 1) + A(0, 2) * B(0, 2) + A(1, 2) * B(1, 2));
  }

  // Coefficients in the order of PlanePoint::products(). Those of the distortion end with degree 2:
  // its cubic ones are -2 times those of J.
  Invariants<Real> start_;
  std::array<Real, 9> J_;
  std::array<Real, 5> distortion_;
  std::array<Real, 14> second_;
};

}  // namespace trefoil
