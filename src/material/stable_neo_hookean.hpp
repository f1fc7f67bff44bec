#pragma once

#include "material/material.hpp"

namespace trefoil {

/// Stable Neo-Hookean energy without the logarithmic barrier (Smith, de Goes, Kim 2018, "Stable
/// Neo-Hookean flesh simulation", equation 13 less its regularised origin barrier):
///   psi(F) = mu/2 (F:F - 3) + lambda/2 (J - alpha)^2,   J = det F,  alpha = 1 + mu/lambda.
/// Finite for every F, inverted ones included. At rest psi(I) = mu^2 / (2 lambda), P(I) = 0.
class StableNeoHookean {
 public:
  /// How E and nu become mu and lambda of the energy.
  enum class Lame {
    physical,  ///< lambda = lambda_Lame + mu, so that small strains obey E and nu
    raw        ///< lambda = lambda_Lame, as Chen et al. 2024 use it; needs nu > 0
  };

  StableNeoHookean(const ElasticConstants &constants, Lame lame)
      : mu_(constants.mu()),
        lambda_(constants.lambda() + (lame == Lame::physical ? constants.mu() : 0)),
        alpha_(1 + mu_ / lambda_) {}

  [[nodiscard]] double mu() const { return mu_; }
  [[nodiscard]] double lambda() const { return lambda_; }

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    const Real volume_change = determinant(F) - alpha_;
    return 0.5 * mu_ * (squared_norm(F) - 3.0) + 0.5 * lambda_ * volume_change * volume_change;
  }

  /// P = mu F + lambda (J - alpha) cof F.
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    const Real pressure = lambda_ * (determinant(F) - alpha_);
    Matrix3<Real> P = cofactor(F);
    for (std::size_t k = 0; k < 9; ++k) P.entries[k] = mu_ * F.entries[k] + pressure * P.entries[k];
    return P;
  }

  /// dP/dF = mu I + lambda cof F (x) cof F + lambda (J - alpha) d(cof F)/dF. The last term's entry
  /// (ij, kl) is, with the permutation symbol, eps_ikm eps_jln F_mn.
  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    const Matrix3<Real> C = cofactor(F);
    const Real pressure = lambda_ * (determinant(F) - alpha_);
    for (std::size_t p = 0; p < 9; ++p) {
      for (std::size_t q = 0; q < 9; ++q) {
        A[9 * p + q] = lambda_ * C.entries[p] * C.entries[q];
      }
      A[9 * p + p] = A[9 * p + p] + mu_;
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int di = 1; di < 3; ++di) {
          for (int dj = 1; dj < 3; ++dj) {
            const int k = (i + di) % 3, l = (j + dj) % 3;
            const int m = 3 - i - k, n = 3 - j - l;
            const double sign = di == dj ? 1.0 : -1.0;
            Real &entry = A[static_cast<std::size_t>(9 * (3 * i + j) + 3 * k + l)];
            entry = entry + sign * pressure * F(m, n);
          }
        }
      }
    }
  }

 private:
  double mu_, lambda_, alpha_;
};

static_assert(Material<StableNeoHookean>);

}  // namespace trefoil
