#pragma once

#include "material/library_material.hpp"
#include "trefoil/material.hpp"
#include "trefoil/polar.hpp"

namespace trefoil {

// Energies that spread prescribed displacements over a body, for a start. Both have the tangent
// k I, the second one at fixed rotations: local/global steps need no other.

/// psi = k/2 |F - I|^2: its minimum is the harmonic extension of the prescribed displacement.
class HarmonicSpreading : public LibraryMaterial<HarmonicSpreading> {
 public:
  explicit HarmonicSpreading(double stiffness) : stiffness_(stiffness) {}

  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    return 0.5 * stiffness_ * squared_norm(deformation.H());
  }
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    Matrix3<Real> P = deformation.H();
    for (Real &entry : P.entries) entry = stiffness_ * entry;
    return P;
  }
  template <class Real>
  void tangent(const Deformation<Real> &, Tangent<Real> &A) const {
    for (std::size_t p = 0; p < 81; ++p) A[p] = Real(p % 10 == 0 ? stiffness_ : 0.0);
  }

 private:
  double stiffness_;
};

/// psi = k/2 |F - R|^2, R the rotation nearest to F: as rigid as possible (Sorkine and Alexa 2007,
/// "As-rigid-as-possible surface modeling").
class RigidSpreading : public LibraryMaterial<RigidSpreading> {
 public:
  explicit RigidSpreading(double stiffness) : stiffness_(stiffness) {}

  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    return 0.5 * stiffness_ * squared_norm(PolarDecomposition(deformation).biot_strain);
  }
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    const PolarDecomposition<Real> polar(deformation);
    Matrix3<Real> P = product(polar.rotation, polar.biot_strain);
    for (Real &entry : P.entries) entry = stiffness_ * entry;
    return P;
  }
  template <class Real>
  void tangent(const Deformation<Real> &, Tangent<Real> &A) const {
    for (std::size_t p = 0; p < 81; ++p) A[p] = Real(p % 10 == 0 ? stiffness_ : 0.0);
  }

 private:
  double stiffness_;
};

}  // namespace trefoil
