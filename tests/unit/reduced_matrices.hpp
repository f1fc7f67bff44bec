#pragma once

// 9x9 matrices for the test and the benchmark of split_reduced().

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "filter/reduced_filter.hpp"

namespace trefoil::reduced_matrices {

constexpr int n = reduced_rows;
using Matrix = std::array<double, n * n>;  // by rows
using Vector3 = std::array<double, 3>;
using Matrix3 = std::array<Vector3, 3>;  // three rows
using Random = std::mt19937_64;

inline double normal(Random &random) {
  return std::normal_distribution<double>()(random);
}
inline double uniform(Random &random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

inline double dot(const Vector3 &x, const Vector3 &y) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}
inline Vector3 cross(const Vector3 &x, const Vector3 &y) {
  return {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
}
inline Vector3 times(const Matrix3 &A, const Vector3 &x) {
  return {dot(A[0], x), dot(A[1], x), dot(A[2], x)};
}
inline Matrix3 transposed(const Matrix3 &A) {
  return {{{A[0][0], A[1][0], A[2][0]}, {A[0][1], A[1][1], A[2][1]}, {A[0][2], A[1][2], A[2][2]}}};
}
inline Matrix3 product(const Matrix3 &A, const Matrix3 &B) {
  const Matrix3 Bt = transposed(B);
  return {times(Bt, A[0]), times(Bt, A[1]), times(Bt, A[2])};
}
inline Matrix3 cofactors(const Matrix3 &A) {
  return {cross(A[1], A[2]), cross(A[2], A[0]), cross(A[0], A[1])};
}
inline double determinant(const Matrix3 &A) {
  return dot(A[0], cross(A[1], A[2]));
}

/// A random rotation [Gram-Schmidt].
inline Matrix3 rotation(Random &random) {
  Matrix3 Q;
  for (auto &row : Q) {
    for (double &q : row) q = normal(random);
  }
  const auto unit = [](Vector3 x) {
    const double length = std::sqrt(dot(x, x));
    return Vector3{x[0] / length, x[1] / length, x[2] / length};
  };
  Q[0] = unit(Q[0]);
  Q[2] = unit(cross(Q[0], Q[1]));
  Q[1] = cross(Q[2], Q[0]);
  return Q;
}

/// A tetrahedron's edges from its first corner, as rows: a unit one, shaken and squeezed.
inline Matrix3 tetrahedron(Random &random, double shake, double squeeze) {
  Matrix3 edges{
      {{1, 0, 0}, {0.5, std::sqrt(0.75), 0}, {0.5, std::sqrt(1.0 / 12), std::sqrt(2.0 / 3)}}};
  for (auto &edge : edges) {
    for (double &x : edge) x += shake * normal(random);
  }
  const Matrix3 Q = rotation(random);
  for (auto &edge : edges) {
    edge = times(Q, edge);
    edge[2] *= squeeze;
  }
  return edges;
}

/// Stable Neo-Hookean, psi = mu/2 (|F|^2 - 3) + lambda/2 (J - alpha)^2, alpha = 1 + mu/lambda, of a
/// linear tetrahedron at the deformation gradient F, in the basis without translations:
///     K_kl = V (mu g_k.g_l I + lambda c_k c_l' - lambda (J - alpha) [F (g_k x g_l)]_x),
/// c_k = cof(F) g_k; g_k from the gradients of the shape functions by Hadamard's vectors.
inline Matrix element(const Matrix3 &edges, const Matrix3 &F, double poisson) {
  const double mu = 1, lambda = 2 * mu * poisson / (1 - 2 * poisson), alpha = 1 + mu / lambda;
  const double volume = std::abs(determinant(edges)) / 6, J = determinant(F);
  // Gradients are the rows of the inverse of the matrix whose columns are the edges.
  const Matrix3 cofactor = cofactors(edges), cof_F = cofactors(F);
  std::array<Vector3, 4> gradient{};
  for (int a = 0; a < 3; ++a) {
    for (int c = 0; c < 3; ++c) {
      gradient[a + 1][c] = cofactor[a][c] / determinant(edges);
      gradient[0][c] -= gradient[a + 1][c];
    }
  }
  const double hadamard[3][4] = {{.5, -.5, .5, -.5}, {.5, .5, -.5, -.5}, {.5, -.5, -.5, .5}};
  Matrix3 g{}, c;
  for (int k = 0; k < 3; ++k) {
    for (int a = 0; a < 4; ++a) {
      for (int i = 0; i < 3; ++i) g[k][i] += hadamard[k][a] * gradient[a][i];
    }
    c[k] = times(cof_F, g[k]);
  }
  Matrix K{};
  for (int k = 0; k < 3; ++k) {
    for (int l = 0; l < 3; ++l) {
      const Vector3 w = times(F, cross(g[k], g[l]));
      const Matrix3 w_cross{{{0, -w[2], w[1]}, {w[2], 0, -w[0]}, {-w[1], w[0], 0}}};
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          K[n * (3 * k + i) + 3 * l + j] =
              volume * (mu * dot(g[k], g[l]) * (i == j) + lambda * c[k][i] * c[l][j] -
                        lambda * (J - alpha) * w_cross[i][j]);
        }
      }
    }
  }
  for (int i = 0; i < n; ++i) {  // symmetric to the last bit
    for (int j = 0; j < i; ++j) K[n * j + i] = K[n * i + j];
  }
  return K;
}

/// F = U diag(stretches) V'
inline Matrix3 deformation(Random &random, const Vector3 &stretches) {
  const Matrix3 U = rotation(random), V = rotation(random);
  Matrix3 scaled = transposed(V);
  for (int i = 0; i < 3; ++i) {
    for (double &x : scaled[i]) x *= stretches[i];
  }
  return product(U, scaled);
}

/// An element as in a large deformation under way: volume kept to about what the material allows.
inline Matrix stretched_element(Random &random, double poisson) {
  const double a = std::exp(0.35 * normal(random)), b = std::exp(0.35 * normal(random));
  const double slack = std::min(0.3, 4 * (1 - 2 * poisson));
  const double J = 1 + slack * normal(random);
  return element(tetrahedron(random, 0.15, uniform(random, 0.3, 1)),
                 deformation(random, {a, b, J / (a * b)}), poisson);
}

/// Matrices into packs; the last one is filled up with copies of the last matrix.
inline std::vector<double> packed(const std::vector<Matrix> &matrices) {
  const std::size_t packs = (matrices.size() + lanes - 1) / lanes;
  std::vector<double> K(packs * reduced_entries * lanes);
  for (std::size_t m = 0; m < packs * lanes; ++m) {
    const Matrix &A = matrices[std::min(m, matrices.size() - 1)];
    double *at = &K[m / lanes * reduced_entries * lanes + m % lanes];
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j, at += lanes) *at = A[n * i + j];
    }
  }
  return K;
}

}  // namespace trefoil::reduced_matrices
