#pragma once

#include <array>

namespace trefoil {

/// A 3x3 matrix, row by row. `Real` is a number, or a pack of numbers that holds the same entry of
/// several matrices.
template <class Real>
struct Matrix3 {
  std::array<Real, 9> entries{};

  Real &operator()(int i, int j) { return entries[static_cast<std::size_t>(3 * i + j)]; }
  const Real &operator()(int i, int j) const {
    return entries[static_cast<std::size_t>(3 * i + j)];
  }
};

/// The cofactor matrix, d det(F) / dF.
template <class Real>
Matrix3<Real> cofactor(const Matrix3<Real> &F) {
  Matrix3<Real> C;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      C(i, j) = F(i1, j1) * F(i2, j2) - F(i1, j2) * F(i2, j1);
    }
  }
  return C;
}

/// What cof(A + B) has beside cof A and cof B: linear in each.
template <class Real>
Matrix3<Real> mixed_cofactor(const Matrix3<Real> &A, const Matrix3<Real> &B) {
  Matrix3<Real> C;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      C(i, j) = (A(i1, j1) * B(i2, j2) + B(i1, j1) * A(i2, j2)) -
                (A(i1, j2) * B(i2, j1) + B(i1, j2) * A(i2, j1));
    }
  }
  return C;
}

template <class Real>
Real determinant(const Matrix3<Real> &F) {
  return F(0, 0) * (F(1, 1) * F(2, 2) - F(1, 2) * F(2, 1)) +
         F(0, 1) * (F(1, 2) * F(2, 0) - F(1, 0) * F(2, 2)) +
         F(0, 2) * (F(1, 0) * F(2, 1) - F(1, 1) * F(2, 0));
}

template <class Real>
Matrix3<Real> product(const Matrix3<Real> &A, const Matrix3<Real> &B) {
  Matrix3<Real> C;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) C(i, j) = A(i, 0) * B(0, j) + A(i, 1) * B(1, j) + A(i, 2) * B(2, j);
  }
  return C;
}

/// A : B, the sum of the products of their entries.
template <class Real>
Real contraction(const Matrix3<Real> &A, const Matrix3<Real> &B) {
  Real sum = A.entries[0] * B.entries[0];
  for (std::size_t k = 1; k < 9; ++k) sum = sum + A.entries[k] * B.entries[k];
  return sum;
}

/// F : F, the square of the Frobenius norm.
template <class Real>
Real squared_norm(const Matrix3<Real> &F) {
  return contraction(F, F);
}

/// A fourth-order tensor dP/dF as a 9x9 matrix: entry (3 i + j, 3 k + l) is dP_ij / dF_kl.
template <class Real>
using Tangent = std::array<Real, 81>;

}  // namespace trefoil
