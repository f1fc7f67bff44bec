#pragma once

#include <array>
#include <cstdint>

#include "contact/vector3.hpp"

namespace trefoil::contact {

/// The two primitives of a pair, by the four points that they take: a vertex and a triangle
/// (x0; x1 x2 x3), two edges (x0 x1; x2 x3), or in the plane a vertex and an edge (x0; x1 x2),
/// where x3 is not used.
enum class PairKind : std::uint8_t { vertex_triangle, edge_edge, vertex_edge };
using PairPoints = std::array<Vector3, 4>;

/// How many of the points belong to the first primitive, and to both.
constexpr int points_of_first(PairKind kind) {
  return kind == PairKind::edge_edge ? 2 : 1;
}
constexpr int points_of_pair(PairKind kind) {
  return kind == PairKind::vertex_edge ? 3 : 4;
}

/// Which parts of the two primitives are nearest to each other.
enum class Nearest : std::uint8_t { point_point, point_edge, point_triangle, edge_edge };

/// The nearest points of two primitives,
///     r = sum_i weights[i] x_i = distance * normal,
/// from the second to the first. They move within their primitives by `parameters` numbers beta:
/// r grows by x_to - x_from with each of them, and r is orthogonal to these edges.
struct NearestPoints {
  Nearest nearest = Nearest::point_point;
  double distance = 0;
  Vector3 normal;  ///< unit; zero where the two touch in a point or an edge
  std::array<double, 4> weights{};
  int parameters = 0;  ///< 0 point_point, 1 point_edge, 2 point_triangle and edge_edge
  std::array<int, 2> from{}, to{};
};

/// The distance of two primitives. The points found belong to the primitives, so that the distance
/// is never too small by more than rounding, eps times their size; degenerate triangles, edges
/// without length and parallel edges included, it is too large by no more either: wherever the
/// interior's equations do not decide, every boundary that may hold the minimum is looked at.
NearestPoints nearest_points(PairKind kind, const PairPoints &x);

}  // namespace trefoil::contact
