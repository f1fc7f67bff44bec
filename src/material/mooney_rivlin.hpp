#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/volume_term.hpp"

namespace trefoil {

/// Mooney's and Rivlin's energy with a volume term, finite for every F, inverted ones included:
///   psi(F) = c1 (I1 - 3) + c2 (I2 - 3) - (2 c1 + 4 c2)(J - 1) + kappa/2 (J - 1)^2,
///   I1 = F:F,  I2 = cof F : cof F,  J = det F.
/// The term linear in J makes the rest state free of stress, where Ciarlet and Geymonat (1982)
/// have log J, which knows no inverted F.
///
/// Small strains obey mu = 2 (c1 + c2) and lambda = kappa - 2 c1. So c2 = s mu/2 and
/// c1 = (1 - s) mu/2 with s = MaterialParameters::second_invariant, 1/2 unless it is given, and
/// kappa = lambda + 2 c1 unless it is given.
class MooneyRivlin : public LibraryMaterial<MooneyRivlin> {
 public:
  static constexpr const char *name = "mooney_rivlin";
  static constexpr bool has_volume_term = true;
  static constexpr bool has_second_invariant = true;

  explicit MooneyRivlin(const MaterialParameters &parameters)
      : c2_(0.5 * parameters.second_invariant.value_or(0.5) * parameters.constants.mu()),
        c1_(0.5 * parameters.constants.mu() - c2_),
        volume_(parameters.volume_weight(name, parameters.constants.lambda() + 2 * c1_),
                2 * c1_ + 4 * c2_) {}

  template <class Real>
  Real energy_density(const Matrix3<Real> &F) const {
    return c1_ * (squared_norm(F) - 3.0) + c2_ * (squared_norm(cofactor(F)) - 3.0) +
           volume_.energy_density(F);
  }

  /// dI1/dF = 2 F,  dI2/dF = 2 (I1 F - F F'F).
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    Matrix3<Real> P = cube(F);
    const Real factor = 2.0 * (c1_ + c2_ * squared_norm(F));
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] = factor * F.entries[k] - 2.0 * c2_ * P.entries[k];
    }
    volume_.add_stress(F, P);
    return P;
  }

  template <class Real>
  void tangent(const Matrix3<Real> &F, Tangent<Real> &A) const {
    set_square(4.0 * c2_, F, A);
    add_identity(2.0 * (c1_ + c2_ * squared_norm(F)), A);
    add_cube_derivative(-2.0 * c2_, F, A);
    volume_.add_tangent(F, A);
  }

 private:
  double c2_, c1_;
  VolumeTerm volume_;
};

static_assert(SceneMaterial<MooneyRivlin>);

}  // namespace trefoil
