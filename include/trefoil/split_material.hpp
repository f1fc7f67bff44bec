#pragma once

#include <algorithm>

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

template <class Real>
VolumetricLaw<Real> scaled(double factor, const VolumetricLaw<Real> &law) {
  return {factor * law.energy, factor * law.slope, factor * law.curvature};
}

/// The weight of U that stays at the points, over mu. Less is more accurate and less stable: in a
/// block compressed by half 2 and 3 turn elements inside out, see examples/README.md.
inline constexpr double pointwise_volume_weight = 6;

template <class M>
class PointwiseMaterial;

/// The base of a material M whose energy density is a sum, psi(F) = W(F) + U(J), where the weight
/// of U is what grows without bound as Poisson's ratio goes to 1/2. Both parts are free of stress
/// at rest, so that neither hides the other's digits at small strains: a term linear in J belongs
/// to W.
///
/// M offers, for numbers and packs,
/// - distortional_energy(deformation): W; may take Invariants as well, see HasEnergyOfInvariants
/// - stress_at_pressure(deformation, p): dW/dF + p cof F; p in place of U'(J), so positive in
///   tension [Simo, Taylor, Pister 1985]
/// - add_tangent_at_pressure(deformation, p, A): its derivative at this p is added,
///   A += d^2W/dF^2 + p d(cof F)/dF
/// - volumetric_law(J - 1): U and its derivatives
/// - mu(), the shear modulus at small strains, if elements may split it
/// and has from here what a Material must have.
///
/// Elements with a pressure of their own take a share s of U at their mean of J, theta: what stays
/// at the points is W + (1 - s) U(J), and the element has s U(theta) per volume. What stays weighs
/// as much as in a body far from incompressible, (1 - s) U''(1) = pointwise_volume_weight mu, and
/// so does not lock whatever Poisson's ratio. Without it the points of an element could trade
/// volumes, and a body that is compressed evenly between free sides would be no minimum.
template <class M>
class SplitMaterial {
 public:
  using PointwisePart = PointwiseMaterial<M>;

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

  /// s; 0 in a body that is compressible enough as it is.
  [[nodiscard]] double mean_share() const {
    const double stiffness = derived().volumetric_law(0.0).curvature;
    return std::max(0.0, 1 - pointwise_volume_weight * derived().mu() / stiffness);
  }

  /// s U and its derivatives at J = theta.
  template <class Real>
  VolumetricLaw<Real> mean_law(const Real &theta_minus_1) const {
    return scaled(mean_share(), derived().volumetric_law(theta_minus_1));
  }

 private:
  [[nodiscard]] const M &derived() const { return static_cast<const M &>(*this); }
};

/// What an element with a pressure of its own leaves of M at the points, W + (1 - s) U(J). Keeps a
/// reference to M.
template <class M>
class PointwiseMaterial : public SplitMaterial<PointwiseMaterial<M>> {
 public:
  using Whole = M;
  explicit PointwiseMaterial(const M &whole) : whole_(whole), share_(1 - whole.mean_share()) {}

  template <class Real>
  VolumetricLaw<Real> volumetric_law(const Real &J_minus_1) const {
    return scaled(share_, whole_.volumetric_law(J_minus_1));
  }

  template <class State>
  auto distortional_energy(const State &state) const requires requires(const M &whole) {
    whole.distortional_energy(state);
  }
  { return whole_.distortional_energy(state); }

  template <class Real>
  Matrix3<Real> stress_at_pressure(const Deformation<Real> &deformation, const Real &p) const {
    return whole_.stress_at_pressure(deformation, p);
  }

  template <class Real>
  void add_tangent_at_pressure(const Deformation<Real> &deformation, const Real &p,
                               Tangent<Real> &A) const {
    whole_.add_tangent_at_pressure(deformation, p, A);
  }

 private:
  const M &whole_;
  double share_;  ///< 1 - s
};

}  // namespace trefoil
