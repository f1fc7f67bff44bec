#pragma once

namespace trefoil {

/// A simplex of order 1 or 2 on its reference cell, the unit triangle or unit tetrahedron, with the
/// shape functions' gradients at its quadrature points. Nodes: corners, then midpoints of the edges
/// (0,1) (1,2) (2,0), in a tetrahedron also (0,3) (1,3) (2,3).
///
/// The quadrature rules. Elastic energies are integrated by the smallest rule that integrates the
/// stiffness of linear elasticity on straight-sided cells exactly: gradients of order-2 shape
/// functions are linear, so degree 2 for order 2 (3 and 4 points), and one point for order 1. That
/// keeps the order of convergence [Ciarlet, The Finite Element Method for Elliptic Problems, 1978,
/// section 4.1: degree 2 k - 2] and the rank: 4 points x 6 strains = 30 - 6 rigid modes of the
/// ten-node tetrahedron, 3 x 3 = 12 - 3 of the six-node triangle. More points would cost in
/// proportion, and constrain volume more often, which nearly incompressible bodies resent.
struct ReferenceElement {
  static constexpr int most_nodes = 10, most_points = 4;

  const char *name;  ///< "tri3", "tri6", "tet4", "tet10"
  int dimension, nodes, points;
  double volume;  ///< of the reference cell, 1/2 or 1/6; all points have the same weight
  double position[most_points][3];               ///< of the quadrature points
  double values[most_points][most_nodes];        ///< of the shape functions there
  double gradients[most_points][most_nodes][3];  ///< d(shape function) / d(reference coordinate)
};

/// The element of a dimension (2, 3) and number of nodes (3, 6; 4, 10).
const ReferenceElement &reference_element(int dimension, int nodes);

/// Values and gradients of the element's shape functions anywhere, for tests and errors of fields.
void shape_functions(int dimension, int nodes, const double *position, double *values,
                     double (*gradients)[3]);

}  // namespace trefoil
