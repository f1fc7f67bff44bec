#pragma once

#include "trefoil/deformation.hpp"
#include "trefoil/tangent_terms.hpp"

namespace trefoil {

/// U, dU/dJ and d^2U/dJ^2 of an energy U(J).
template <class Real>
struct VolumetricLaw {
  Real energy, slope, curvature;
};

/// U = kappa/2 (J - 1)^2.
template <class Real>
VolumetricLaw<Real> quadratic_law(double kappa, const Real &J_minus_1) {
  return {0.5 * kappa * J_minus_1 * J_minus_1, kappa * J_minus_1, Real(kappa)};
}

/// The base of a material M whose energy density is a sum, psi(F) = W(F) + U(J), with all that
/// depends on J alone in U. Both parts are free of stress at rest, so that neither hides the
/// other's digits at small strains: a term linear in J belongs to W.
///
/// M offers, for numbers and packs,
/// - distortional_energy(deformation): W; may take Invariants as well, see HasEnergyOfInvariants
/// - stress_at_pressure(deformation, p): dW/dF + p cof F; p in place of U'(J), so positive in
///   tension [Simo, Taylor, Pister 1985]
/// - add_tangent_at_pressure(deformation, p, A): its derivative at this p is added,
///   A += d^2W/dF^2 + p d(cof F)/dF
/// - volumetric_law(J - 1): U and its derivatives
/// and has from here what a Material must have.
template <class M>
class SplitMaterial {
 public:
  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    return derived().distortional_energy(deformation) +
           derived().volumetric_law(deformation.J_minus_1()).energy;
  }

  /// Where M has W of invariants.
  template <class Real>
  Real energy_of_invariants(const Invariants<Real> &invariants) const requires
      requires(const M &material) {
    material.distortional_energy(invariants);
  }
  {
    return derived().distortional_energy(invariants) +
           derived().volumetric_law(invariants.J_minus_1).energy;
  }

  /// P = dW/dF + U'(J) cof F.
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    return derived().stress_at_pressure(deformation,
                                        derived().volumetric_law(deformation.J_minus_1()).slope);
  }

  /// dP/dF = d^2W/dF^2 + U'(J) d(cof F)/dF + U''(J) cof F (x) cof F.
  template <class Real>
  void tangent(const Deformation<Real> &deformation, Tangent<Real> &A) const {
    const VolumetricLaw<Real> law = derived().volumetric_law(deformation.J_minus_1());
    set_square(law.curvature, deformation.cofactor(), A);
    derived().add_tangent_at_pressure(deformation, law.slope, A);
  }

 private:
  [[nodiscard]] const M &derived() const { return static_cast<const M &>(*this); }
};

}  // namespace trefoil
