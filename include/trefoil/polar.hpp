#pragma once

#include "trefoil/branch_free.hpp"
#include "trefoil/deformation.hpp"

namespace trefoil {

/// F = U diag(stretch) V' with proper rotations U and V (det = +1): stretch[0] >= stretch[1] >=
/// |stretch[2]| to rounding, and the last one is negative where det F is.
template <class Real>
struct SignedSvd {
  Matrix3<Real> U, V;
  std::array<Real, 3> stretch;
};

namespace polar {

/// The squared length of column j of A, and the product of two columns.
template <class Real>
Real column_product(const Matrix3<Real> &A, int i, int j) {
  return A(0, i) * A(0, j) + A(1, i) * A(1, j) + A(2, i) * A(2, j);
}

/// Turns columns i and j of A by the angle with cosine c and sine s.
template <class Real>
void turn_columns(Matrix3<Real> &A, int i, int j, const Real &c, const Real &s) {
  for (int row = 0; row < 3; ++row) {
    const Real left = A(row, i), right = A(row, j);
    A(row, i) = c * left - s * right;
    A(row, j) = s * left + c * right;
  }
}

/// Turns columns i and j of B = F V so that they become orthogonal, and V with them. Columns that
/// are so to rounding are left as they are, so that a lane's result does not depend on how long the
/// other lanes take. Returns where it turned any.
template <class Real>
auto orthogonalize(Matrix3<Real> &B, Matrix3<Real> &V, int i, int j) {
  constexpr double tolerance = 1e-15;
  const Real a = column_product(B, i, i), b = column_product(B, j, j);
  const Real product = column_product(B, i, j);
  const auto turning = product * product > (tolerance * tolerance) * a * b;
  // tan of the smaller of the two angles that do it.
  const Real difference = b - a;
  const Real root = sqrt(difference * difference + 4.0 * product * product);
  const Real tangent =
      select(difference < Real(0.0), -2.0 * product, 2.0 * product) / (abs(difference) + root);
  const Real t = select(turning, tangent, Real(0.0));
  const Real c = 1.0 / sqrt(1.0 + t * t);
  turn_columns(B, i, j, c, t * c);
  turn_columns(V, i, j, c, t * c);
  return turning;
}

/// Exchanges columns i and j, one of them negated, where the second is the longer one.
template <class Real>
void sort_columns(Matrix3<Real> &B, Matrix3<Real> &V, int i, int j) {
  const auto exchange = column_product(B, i, i) < column_product(B, j, j);
  for (Matrix3<Real> *A : {&B, &V}) {
    for (int row = 0; row < 3; ++row) {
      const Real left = (*A)(row, i), right = (*A)(row, j);
      (*A)(row, i) = select(exchange, right, left);
      (*A)(row, j) = select(exchange, -left, right);
    }
  }
}

/// U's columns from those of B = U diag(stretch): the longest, what is left of the second, and
/// their cross product. Where B has no first or second column, any that fit.
template <class Real>
void complete_rotation(const Matrix3<Real> &B, Matrix3<Real> &U) {
  constexpr double nothing = 1e-150;
  const Real first = sqrt(column_product(B, 0, 0));
  const auto no_first = first <= Real(nothing);
  for (int i = 0; i < 3; ++i) {
    U(i, 0) = select(no_first, Real(i == 0 ? 1.0 : 0.0), B(i, 0) / first);
  }
  Real along = U(0, 0) * B(0, 1) + U(1, 0) * B(1, 1) + U(2, 0) * B(2, 1);
  for (int i = 0; i < 3; ++i) U(i, 1) = B(i, 1) - along * U(i, 0);
  const Real second = sqrt(column_product(U, 1, 1));
  const auto no_second = second <= nothing * (1.0 + first);
  // At right angles to u_1: (u, v, w) and (-v, u, 0), or (-w, 0, u), whichever is longer.
  const Real u = U(0, 0), v = U(1, 0), w = U(2, 0);
  const auto by_v = abs(v) > abs(w);
  const Real other = select(by_v, v, w);
  const Real length = sqrt(u * u + other * other);
  const Real fallback[3] = {-other / length, select(by_v, u, Real(0.0)) / length,
                            select(by_v, Real(0.0), u) / length};
  for (int i = 0; i < 3; ++i) U(i, 1) = select(no_second, fallback[i], U(i, 1) / second);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    U(i, 2) = U(j, 0) * U(k, 1) - U(k, 0) * U(j, 1);
  }
}

}  // namespace polar

/// The singular value decomposition of a 3x3 matrix, or of a pack of them, by one-sided Jacobi
/// rotations (Hestenes 1958, "Inversion of matrices by biorthogonalization"; Golub and Van Loan,
/// "Matrix computations", 8.6.3): errors of a few eps |F|, also of the singular vectors' products,
/// for singular, inverted and repeated singular values alike. Entries between 1e-75 and 1e75, or 0;
/// one that is not a number makes U and `stretch` so.
template <class Real>
SignedSvd<Real> signed_svd(const Matrix3<Real> &F) {
  constexpr int most_sweeps = 12;  // convergence is quadratic: four or five are the rule
  Matrix3<Real> B = F;
  SignedSvd<Real> svd;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) svd.V(i, j) = Real(i == j ? 1.0 : 0.0);
  }
  bool turned = true;
  for (int sweep = 0; turned && sweep < most_sweeps; ++sweep) {
    const auto first = polar::orthogonalize(B, svd.V, 0, 1);
    const auto second = polar::orthogonalize(B, svd.V, 0, 2);
    const auto third = polar::orthogonalize(B, svd.V, 1, 2);
    turned = any(first) || any(second) || any(third);
  }
  polar::sort_columns(B, svd.V, 0, 1);
  polar::sort_columns(B, svd.V, 1, 2);
  polar::sort_columns(B, svd.V, 0, 1);
  polar::complete_rotation(B, svd.U);
  for (int k = 0; k < 3; ++k) {
    svd.stretch[static_cast<std::size_t>(k)] =
        svd.U(0, k) * B(0, k) + svd.U(1, k) * B(1, k) + svd.U(2, k) * B(2, k);
  }
  return svd;
}

/// U V', the proper rotation (det = +1) nearest to F, which makes R'F symmetric; for an inverted F
/// too, where the smallest stretch is negative. Where the two smallest stretches add up to zero
/// there are several, and this is one of them.
template <class Real>
Matrix3<Real> rotation_of(const SignedSvd<Real> &svd) {
  Matrix3<Real> R;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      R(i, j) = svd.U(i, 0) * svd.V(j, 0) + svd.U(i, 1) * svd.V(j, 1) + svd.U(i, 2) * svd.V(j, 2);
    }
  }
  return R;
}

/// F = R S with the rotation R and a symmetric S. What strains is the Biot strain S - I, and
/// F - R = R (S - I).
template <class Real>
struct PolarDecomposition {
  SignedSvd<Real> svd;  ///< of F
  Matrix3<Real> rotation, biot_strain;

  explicit PolarDecomposition(const Deformation<Real> &deformation)
      : svd(signed_svd(deformation.F())),
        rotation(rotation_of(svd)),
        biot_strain(strain_of(svd, deformation)) {}

 private:
  /// Y = V diag(stretch - 1) V', whose error is rounding of numbers of order one. At small strains
  /// 2 Y + Y^2 = 2 E, with Green's strain E to rounding of itself, gives Y = E - Y^2/2 once more:
  /// the error becomes |Y| times what it was.
  static Matrix3<Real> strain_of(const SignedSvd<Real> &svd, const Deformation<Real> &deformation) {
    constexpr double largest = 0.25;
    Matrix3<Real> V = svd.V, Y;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k)
        V(i, k) = V(i, k) * (svd.stretch[static_cast<std::size_t>(k)] - 1.0);
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        Y(i, j) = V(i, 0) * svd.V(j, 0) + V(i, 1) * svd.V(j, 1) + V(i, 2) * svd.V(j, 2);
      }
    }
    const auto is_small = squared_norm(Y) < Real(largest * largest);
    if (!any(is_small)) return Y;
    const Matrix3<Real> E = deformation.green_strain(), square = product(Y, Y);
    for (std::size_t k = 0; k < 9; ++k) {
      Y.entries[k] = select(is_small, E.entries[k] - 0.5 * square.entries[k], Y.entries[k]);
    }
    return Y;
  }
};

}  // namespace trefoil
