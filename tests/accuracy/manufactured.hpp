#pragma once

// A deformation in closed form, of the unit square or cube, and the body force that it takes.

#include <array>
#include <cmath>
#include <numbers>

#include "trefoil/material_model.hpp"
#include "trefoil/matrix3.hpp"

namespace trefoil::accuracy {

/// The displacement gradient H = F - I, as materials take it.
inline Matrix3<double> less_identity(Matrix3<double> F) {
  for (int i = 0; i < 3; ++i) F(i, i) -= 1;
  return F;
}

/// Shears one after the other, each along one axis by a function of the other (already moved)
/// coordinates: volume is kept exactly, whatever the amplitude. With `swelling` x is moved by a
/// function of x as well, and volume is not kept.
struct Manufactured {
  int dimension = 3;
  double amplitude = 0.08, swelling = 0;

  [[nodiscard]] std::array<double, 3> displacement(const double *p) const {
    const std::array<double, 3> y = moved(p);
    return {y[0] - p[0], y[1] - p[1], dimension == 3 ? y[2] - p[2] : 0};
  }

  /// F = S_3 S_2 S_1 with S_k = I + e_k (x) (gradient of its function).
  [[nodiscard]] Matrix3<double> gradient(const double *p) const {
    const double w = std::numbers::pi, a = amplitude;
    const double z = dimension == 3 ? p[2] : 0;
    const double x1 =
        p[0] + a * std::sin(w * p[1]) * std::cos(w * z) + swelling * std::sin(w * p[0]);
    const double y1 = p[1] + a * std::cos(w * x1 + z);
    Matrix3<double> S1, S2, S3;
    for (Matrix3<double> *S : {&S1, &S2, &S3})
      for (int i = 0; i < 3; ++i) (*S)(i, i) = 1;
    S1(0, 0) += swelling * w * std::cos(w * p[0]);
    S1(0, 1) = a * w * std::cos(w * p[1]) * std::cos(w * z);
    S1(0, 2) = dimension == 3 ? -a * w * std::sin(w * p[1]) * std::sin(w * z) : 0;
    S2(1, 0) = -a * w * std::sin(w * x1 + z);
    S2(1, 2) = dimension == 3 ? -a * std::sin(w * x1 + z) : 0;
    if (dimension == 3) {
      S3(2, 0) = a * w * std::cos(w * x1 - y1);
      S3(2, 1) = -a * std::cos(w * x1 - y1);
    }
    return product(S3, product(S2, S1));
  }

  /// -Div P, per rest volume, by central differences of fourth order.
  [[nodiscard]] std::array<double, 3> body_force(const MaterialModel &material,
                                                 const double *p) const {
    constexpr double h = 1e-3;
    std::array<double, 3> force{};
    for (int j = 0; j < dimension; ++j) {
      for (const auto &[steps, factor] : {std::pair{1, 8.}, {-1, -8.}, {2, -1.}, {-2, 1.}}) {
        double q[3] = {p[0], p[1], p[2]};
        q[j] += steps * h;
        const Matrix3<double> P = material.stress(less_identity(gradient(q)));
        for (std::size_t i = 0; i < 3; ++i)
          force[i] -= factor / (12 * h) * P(static_cast<int>(i), j);
      }
    }
    return force;
  }

 private:
  [[nodiscard]] std::array<double, 3> moved(const double *p) const {
    const double w = std::numbers::pi, a = amplitude;
    const double z = dimension == 3 ? p[2] : 0;
    const double x1 =
        p[0] + a * std::sin(w * p[1]) * std::cos(w * z) + swelling * std::sin(w * p[0]);
    const double y1 = p[1] + a * std::cos(w * x1 + z);
    return {x1, y1, dimension == 3 ? p[2] + a * std::sin(w * x1 - y1) : 0};
  }
};

}  // namespace trefoil::accuracy
