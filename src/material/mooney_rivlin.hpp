#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/split_material.hpp"

namespace trefoil {

/// Mooney's and Rivlin's energy with a volume term, finite for every F, inverted ones included:
///   psi(F) = c1 (I1 - 3) + c2 (I2 - 3) - (2 c1 + 4 c2)(J - 1) + kappa/2 (J - 1)^2,
///   I1 = F:F,  I2 = cof F : cof F,  J = det F.
/// The term linear in J makes the rest state free of stress, where Ciarlet and Geymonat (1982)
/// have log J, which knows no inverted F.
///
/// Small strains obey mu = 2 (c1 + c2) and lambda = kappa - 2 c1. So c2 = s mu/2 and
/// c1 = (1 - s) mu/2 with s = MaterialParameters::second_invariant, 1/2 unless it is given, and
/// kappa = lambda + 2 c1 unless it is given. Volumetric: U(J) = kappa/2 (J - 1)^2.
class MooneyRivlin : public LibraryMaterial<MooneyRivlin>, public SplitMaterial<MooneyRivlin> {
 public:
  static constexpr const char *name = "mooney_rivlin";
  static constexpr bool has_volume_term = true;
  static constexpr bool has_second_invariant = true;

  explicit MooneyRivlin(const MaterialParameters &parameters)
      : c2_(0.5 * parameters.second_invariant.value_or(0.5) * parameters.constants.mu()),
        c1_(0.5 * parameters.constants.mu() - c2_),
        kappa_(parameters.volume_weight(name, parameters.constants.lambda() + 2 * c1_)) {}

  [[nodiscard]] double mu() const { return 2 * (c1_ + c2_); }

  template <class Real>
  VolumetricLaw<Real> volumetric_law(const Real &J_minus_1) const {
    return quadratic_law(kappa_, J_minus_1);
  }

  /// W = c1 (I1 - 3 - 2 (J - 1)) + c2 (I2 - 3 - 4 (J - 1)).
  template <class Real>
  Real distortional_energy(const Deformation<Real> &deformation) const {
    return distortional_energy(deformation.invariants());
  }
  template <class Real>
  Real distortional_energy(const Invariants<Real> &invariants) const {
    return c1_ * invariants.distortion + c2_ * invariants.I2_distortion();
  }

  /// dW/dF = (2 c1 + 4 c2)(F - cof F) + 4 c2 F (tr(E) I - E).
  template <class Real>
  Matrix3<Real> stress_at_pressure(const Deformation<Real> &deformation, const Real &p) const {
    Matrix3<Real> T = deformation.green_strain();
    const Real trace = T(0, 0) + T(1, 1) + T(2, 2);
    for (Real &entry : T.entries) entry = -entry;
    for (int i = 0; i < 3; ++i) T(i, i) = trace + T(i, i);
    const Matrix3<Real> FT = product(deformation.F(), T), D = deformation.F_minus_cofactor(),
                        C = deformation.cofactor();
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k) {
      P.entries[k] =
          (2.0 * c1_ + 4.0 * c2_) * D.entries[k] + 4.0 * c2_ * FT.entries[k] + p * C.entries[k];
    }
    return P;
  }

  /// From dI1/dF = 2 F and dI2/dF = 2 (I1 F - F F'F).
  template <class Real>
  void add_tangent_at_pressure(const Deformation<Real> &deformation, const Real &p,
                               Tangent<Real> &A) const {
    const Matrix3<Real> F = deformation.F();
    add_square(4.0 * c2_, F, A);
    add_identity(2.0 * (c1_ + c2_ * squared_norm(F)), A);
    add_cube_derivative(-2.0 * c2_, F, A);
    add_cofactor_derivative(p - (2.0 * c1_ + 4.0 * c2_), F, A);
  }

 private:
  double c2_, c1_, kappa_;
};

static_assert(SceneMaterial<MooneyRivlin> && VolumeSplittingMaterial<MooneyRivlin>);

}  // namespace trefoil
