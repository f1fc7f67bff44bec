#pragma once

// What the tests of materials and elements share: small matrices, random ones of a fixed seed, and
// a derivative by finite differences.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "trefoil/branch_free.hpp"
#include "trefoil/material.hpp"

namespace trefoil::test {

using Matrix = Matrix3<double>;

inline Matrix diagonal(double a, double b, double c) {
  Matrix D;
  D(0, 0) = a, D(1, 1) = b, D(2, 2) = c;
  return D;
}

inline Matrix operator*(const Matrix &A, const Matrix &B) {
  Matrix C;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) C(i, j) += A(i, k) * B(k, j);
  return C;
}

/// A + s B.
inline Matrix along(const Matrix &A, double s, const Matrix &B) {
  Matrix C = A;
  for (std::size_t k = 0; k < 9; ++k) C.entries[k] += s * B.entries[k];
  return C;
}

/// The displacement gradient H = F - I, as materials take it, and the deformation.
inline Matrix less_identity(const Matrix &F) {
  return along(F, -1, diagonal(1, 1, 1));
}
inline Deformation<double> deformed(const Matrix &F) {
  return Deformation<double>(less_identity(F));
}

inline double dot(const Matrix &A, const Matrix &B) {
  double sum = 0;
  for (std::size_t k = 0; k < 9; ++k) sum += A.entries[k] * B.entries[k];
  return sum;
}

inline double norm(const Matrix &A) {
  return std::sqrt(dot(A, A));
}

inline double norm(const Tangent<double> &A) {
  double sum = 0;
  for (const double entry : A) sum += entry * entry;
  return std::sqrt(sum);
}

/// A : D, the change of the stress along D.
inline Matrix apply(const Tangent<double> &A, const Matrix &D) {
  Matrix result;
  for (std::size_t p = 0; p < 9; ++p)
    for (std::size_t q = 0; q < 9; ++q) result.entries[p] += A[9 * p + q] * D.entries[q];
  return result;
}

/// Numbers that are the same in every run.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  double uniform(double low = -1, double high = 1) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }

  Matrix matrix(double size = 1) {
    Matrix A;
    for (double &entry : A.entries) entry = uniform(-size, size);
    return A;
  }

  /// A proper rotation, from a random unit quaternion.
  Matrix rotation() {
    double q[4], length = 0;
    for (double &entry : q) entry = uniform();
    for (const double entry : q) length += entry * entry;
    for (double &entry : q) entry /= std::sqrt(length);
    const auto [w, x, y, z] = q;
    Matrix Q;
    Q.entries = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                 2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                 2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    return Q;
  }

 private:
  std::mt19937 engine_;
};

/// f'(0) by the central formula on five points, whose error is h^4 f^(5)(0) / 30: large steps, so
/// that rounding costs few digits.
template <class Function>
double derivative(double h, const Function &f) {
  return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h);
}

template <std::size_t size>
double largest(const std::array<double, size> &values) {
  double result = 0;
  for (const double value : values) result = std::max(result, std::abs(value));
  return result;
}

/// A material behind functions of F, so that one test serves all; and of H = F - I.
struct AnyMaterial {
  std::function<double(const Deformation<double> &)> energy_density_of;
  std::function<Matrix(const Deformation<double> &)> stress_of;
  std::function<Tangent<double>(const Deformation<double> &)> tangent_of;

  template <Material M>
  explicit AnyMaterial(const M &material)
      : energy_density_of(
            [=](const auto &deformation) { return material.energy_density(deformation); }),
        stress_of([=](const auto &deformation) { return material.stress(deformation); }),
        tangent_of([=](const auto &deformation) {
          Tangent<double> A;
          material.tangent(deformation, A);
          return A;
        }) {}

  [[nodiscard]] double energy_density(const Matrix &F) const {
    return energy_density_of(deformed(F));
  }
  [[nodiscard]] Matrix stress(const Matrix &F) const { return stress_of(deformed(F)); }
  [[nodiscard]] Tangent<double> tangent(const Matrix &F) const { return tangent_of(deformed(F)); }
};

}  // namespace trefoil::test
