#pragma once

// The linear tetrahedron, one at a time: IsoparametricElement with one point, by short names.

#include <algorithm>

#include "element/isoparametric_element.hpp"

namespace trefoil {

struct Tet4 {
  static constexpr int dofs = 12;  ///< corner by corner, x y z each

  IsoparametricElement element;
  double volume;
  double gradients[4][3];  ///< of the shape functions, 1/length

  /// From rest positions of the corners, 4 x 3.
  static Tet4 at_rest(const double (&corner)[4][3]) {
    Tet4 tet{IsoparametricElement(reference_element(3, 4), &corner[0][0]), 0, {}};
    tet.volume = tet.element.weight(0);
    for (int a = 0; a < 4; ++a) std::copy_n(tet.element.gradient(0, a), 3, tet.gradients[a]);
    return tet;
  }
  [[nodiscard]] Matrix3<double> displacement_gradient(const double *u) const {
    return element.displacement_gradient(0, u);
  }
  void add_force(const Matrix3<double> &P, double *force) const { element.add_force(0, P, force); }
  void hessian(const Tangent<double> &A, double *H) const {
    std::fill_n(H, dofs * dofs, 0.);
    element.add_hessian(0, A, H);
  }
};

}  // namespace trefoil
