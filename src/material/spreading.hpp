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
  Real energy_density(const Matrix3<Real> &F) const {
    Matrix3<Real> strain = F;
    for (int i = 0; i < 3; ++i) strain(i, i) = strain(i, i) - 1.0;
    return 0.5 * stiffness_ * squared_norm(strain);
  }
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    Matrix3<Real> P;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) P(i, j) = stiffness_ * (F(i, j) - (i == j ? 1.0 : 0.0));
    }
    return P;
  }
  template <class Real>
  void tangent(const Matrix3<Real> &, Tangent<Real> &A) const {
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
  Real energy_density(const Matrix3<Real> &F) const {
    return 0.5 * stiffness_ * squared_norm(difference(F));
  }
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    Matrix3<Real> P = difference(F);
    for (Real &entry : P.entries) entry = stiffness_ * entry;
    return P;
  }
  template <class Real>
  void tangent(const Matrix3<Real> &, Tangent<Real> &A) const {
    for (std::size_t p = 0; p < 81; ++p) A[p] = Real(p % 10 == 0 ? stiffness_ : 0.0);
  }

 private:
  template <class Real>
  static Matrix3<Real> difference(const Matrix3<Real> &F) {
    Matrix3<Real> D = rotation_of(F);
    for (std::size_t p = 0; p < 9; ++p) D.entries[p] = F.entries[p] - D.entries[p];
    return D;
  }
  double stiffness_;
};

}  // namespace trefoil
