#pragma once

#include "trefoil/matrix3.hpp"

namespace trefoil {

/// The linear tetrahedron at rest: F = I + sum_a u_a g_a' is constant in it.
struct Tet4 {
  static constexpr int corners = 4;
  static constexpr int dofs = 12;  ///< corner by corner, x y z each

  double gradients[4][3];  ///< g_a, gradients of the four shape functions, 1/length
  double volume;           ///< rest volume

  /// From rest positions of the corners, 4 x 3.
  static Tet4 at_rest(const double (&corner)[4][3]);

  /// F = I + sum_a u_a g_a' from the displacements of the corners, 4 x 3.
  [[nodiscard]] Matrix3<double> deformation_gradient(const double *u) const;

  /// Adds V P g_a to each corner's force; 12 entries.
  void add_force(const Matrix3<double> &P, double *force) const;

  /// H[(a,i),(b,k)] = V sum_jl g_a[j] (dP_ij/dF_kl) g_b[l]; 12 x 12, symmetric.
  void hessian(const Tangent<double> &A, double *H) const;
};

}  // namespace trefoil
