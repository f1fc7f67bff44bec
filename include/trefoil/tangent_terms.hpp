#pragma once

#include "trefoil/branch_free.hpp"
#include "trefoil/matrix3.hpp"
#include "trefoil/polar.hpp"

namespace trefoil {

// The summands of which materials make their tangents A = dP/dF.

/// A += factor I, the derivative of factor F.
template <class Real, class Factor>
void add_identity(const Factor &factor, Tangent<Real> &A) {
  for (std::size_t p = 0; p < 9; ++p) A[10 * p] = A[10 * p] + factor;
}

/// A = factor X (x) X: a sum that begins with this one needs no zeros to add to.
template <class Real, class Factor>
void set_square(const Factor &factor, const Matrix3<Real> &X, Tangent<Real> &A) {
  for (std::size_t p = 0; p < 9; ++p) {
    const Real scaled = factor * X.entries[p];
    for (std::size_t q = 0; q < 9; ++q) A[9 * p + q] = scaled * X.entries[q];
  }
}

/// A += factor X (x) X.
template <class Real, class Factor>
void add_square(const Factor &factor, const Matrix3<Real> &X, Tangent<Real> &A) {
  for (std::size_t p = 0; p < 9; ++p) {
    const Real scaled = factor * X.entries[p];
    for (std::size_t q = 0; q < 9; ++q) A[9 * p + q] = A[9 * p + q] + scaled * X.entries[q];
  }
}

/// A += factor (X (x) Y + Y (x) X).
template <class Real, class Factor>
void add_product(const Factor &factor, const Matrix3<Real> &X, const Matrix3<Real> &Y,
                 Tangent<Real> &A) {
  for (std::size_t p = 0; p < 9; ++p) {
    const Real x = factor * X.entries[p], y = factor * Y.entries[p];
    for (std::size_t q = 0; q < 9; ++q) {
      A[9 * p + q] = A[9 * p + q] + (x * Y.entries[q] + y * X.entries[q]);
    }
  }
}

/// A += factor d(cof F)/dF, whose entry (ij, kl) is, with the permutation symbol,
/// eps_ikm eps_jln F_mn.
template <class Real, class Factor>
void add_cofactor_derivative(const Factor &factor, const Matrix3<Real> &F, Tangent<Real> &A) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int di = 1; di < 3; ++di) {
        for (int dj = 1; dj < 3; ++dj) {
          const int k = (i + di) % 3, l = (j + dj) % 3;
          const int m = 3 - i - k, n = 3 - j - l;
          const double sign = di == dj ? 1.0 : -1.0;
          Real &entry = A[static_cast<std::size_t>(9 * (3 * i + j) + 3 * k + l)];
          entry = entry + sign * factor * F(m, n);
        }
      }
    }
  }
}

/// F F'F, the derivative of (F'F : F'F) / 4.
template <class Real>
Matrix3<Real> cube(const Matrix3<Real> &F) {
  Matrix3<Real> C, product;  // C = F'F
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      C(k, j) = F(0, k) * F(0, j) + F(1, k) * F(1, j) + F(2, k) * F(2, j);
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      product(i, j) = F(i, 0) * C(0, j) + F(i, 1) * C(1, j) + F(i, 2) * C(2, j);
    }
  }
  return product;
}

/// A += factor d(F F'F)/dF, entry (ij, kl): d_ik (F'F)_lj + F_il F_kj + (FF')_ik d_jl.
template <class Real, class Factor>
void add_cube_derivative(const Factor &factor, const Matrix3<Real> &F, Tangent<Real> &A) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) {
          Real sum = F(i, l) * F(k, j);
          for (int m = 0; i == k && m < 3; ++m) sum = sum + F(m, l) * F(m, j);
          for (int m = 0; j == l && m < 3; ++m) sum = sum + F(i, m) * F(k, m);
          Real &entry = A[static_cast<std::size_t>(9 * (3 * i + j) + 3 * k + l)];
          entry = entry + factor * sum;
        }
      }
    }
  }
}

/// Where two stretches add up to less than this (1 is the rest state), the derivative of the
/// rotation counts as if they added up to it: it grows without bound where they add up to zero.
inline constexpr double least_stretch_sum = 1e-6;

/// A += factor dR/dF of the rotation R = U V'. R turns with the three twists
/// u_i v_j' - u_j v_i', each by 1 / (stretch_i + stretch_j).
template <class Real, class Factor>
void add_rotation_derivative(const Factor &factor, const SignedSvd<Real> &svd, Tangent<Real> &A) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    Matrix3<Real> twist;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        twist(row, column) = svd.U(row, i) * svd.V(column, j) - svd.U(row, j) * svd.V(column, i);
      }
    }
    const Real sum =
        svd.stretch[static_cast<std::size_t>(i)] + svd.stretch[static_cast<std::size_t>(j)];
    add_square(factor / max(sum, Real(least_stretch_sum)), twist, A);
  }
}

}  // namespace trefoil
