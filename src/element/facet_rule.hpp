#pragma once

namespace trefoil {

/// Quadrature on what bounds a cell: an edge of two or three nodes, a triangle of three or six.
/// Exact for products of two shape functions on straight facets [Gauss; Strang and Fix, An Analysis
/// of the Finite Element Method, 1973, table 4.1].
struct FacetRule {
  static constexpr int most_nodes = 6, most_points = 6;

  int dimension, nodes, points;
  double weights[most_points];                   ///< their sum is the reference facet's size
  double values[most_points][most_nodes];        ///< of the shape functions
  double gradients[most_points][most_nodes][2];  ///< by the reference coordinates
};

/// @param dimension of the facet: 1 an edge, 2 a triangle
/// @param nodes 2 or 3, 3 or 6
const FacetRule &facet_rule(int dimension, int nodes);

}  // namespace trefoil
