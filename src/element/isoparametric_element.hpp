#pragma once

#include "element/reference_element.hpp"
#include "trefoil/matrix3.hpp"

namespace trefoil {

/// One element at rest, of any kind, straight or bent: positions are interpolated by the shape
/// functions as displacements are. The plain counterpart of the kernels for packs.
///
/// Displacements and forces are nodes x 3 whatever the dimension; in the plane F_33 = 1.
class IsoparametricElement {
 public:
  /// @param positions of the nodes at rest, nodes x 3
  IsoparametricElement(const ReferenceElement &reference, const double *positions);

  [[nodiscard]] const ReferenceElement &reference() const { return reference_; }
  /// Quadrature weight times Jacobian determinant: the volume (area) that point q stands for.
  [[nodiscard]] double weight(int q) const { return weights_[q]; }
  /// Gradient of the shape function of node a at point q, 3 numbers, 1/length.
  [[nodiscard]] const double *gradient(int q, int a) const { return gradients_[q][a]; }
  /// The inverse of the Jacobian matrix at point q: d(reference j) / d(position i) at (j, i).
  [[nodiscard]] const Matrix3<double> &inverse_jacobian(int q) const { return inverses_[q]; }
  /// The least Jacobian determinant at the quadrature points.
  [[nodiscard]] double least_jacobian() const;

  /// The displacement gradient H = F - I = sum_a u_a g_a' at point q.
  [[nodiscard]] Matrix3<double> displacement_gradient(int q, const double *u) const;
  /// Adds w_q P g_a to each node's force.
  void add_force(int q, const Matrix3<double> &P, double *force) const;
  /// Adds w_q sum_jl g_a[j] (dP_ij/dF_kl) g_b[l] to entry (dim a + i, dim b + k) of the Hessian of
  /// dim nodes rows.
  void add_hessian(int q, const Tangent<double> &A, double *H) const;

 private:
  const ReferenceElement &reference_;
  double weights_[ReferenceElement::most_points];
  double gradients_[ReferenceElement::most_points][ReferenceElement::most_nodes][3] = {};
  Matrix3<double> inverses_[ReferenceElement::most_points];
};

}  // namespace trefoil
