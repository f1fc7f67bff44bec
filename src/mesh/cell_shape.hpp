#pragma once

#include <array>
#include <span>
#include <string>

namespace trefoil {

/// The shape of a cell, or of what bounds one: a row of the table in cell_shape.cpp. Whatever works
/// on cells goes by this table, so that another shape is another row.
///
/// A cell names its corners first, then the midpoints of its edges in the order of `edges`, as VTK
/// and XDMF have it.
struct CellShape {
  static constexpr int most_nodes = 10, most_facet_nodes = 6, most_facet_corners = 3;

  const char *name;               ///< "tet10"
  const char *singular, *plural;  ///< "tetrahedron", "tetrahedra"
  int dimension, order, corners, nodes;
  const CellShape *linear, *quadratic;  ///< the same corners, without and with midpoints

  std::span<const std::array<int, 2>> edges;  ///< corners of each
  const CellShape *facet;                     ///< shape of the facets; null of a point
  /// Nodes of each facet, in the order of the facet's shape. Seen from outside of a cell that is
  /// not turned round its corners run anticlockwise; the edges of a plane cell run so around it.
  std::span<const std::array<int, most_facet_nodes>> facets;
  /// A corner and its neighbours along the edges: right-handed, each of them, in a cell that is not
  /// turned round. One is enough for a simplex, whose neighbours are all other corners. The last is
  /// missing (-1) in the plane.
  std::span<const std::array<int, 4>> frames;
  std::span<const int> mirrored;  ///< nodes of the cell turned round: entry k goes to place k
  int children;                   ///< cells that uniform refinement makes of one

  int gmsh_type;                    ///< in Gmsh's MSH formats
  std::span<const int> gmsh_order;  ///< node k of ours is their node gmsh_order[k]
  const char *medit;                ///< section of a Medit file; null: there is none
  const char *xdmf;                 ///< TopologyType in XDMF 3
  int vtk;                          ///< type in VTK's files
};

/// The rows of the table. Points, edges and triangles are also what bounds cells.
namespace shapes {
extern const CellShape point, edge2, edge3, tri3, tri6, tet4, tet10;
}

/// Whether `shape` has midpoints.
inline bool is_quadratic(const CellShape &shape) {
  return shape.order == 2;
}

/// "1 tetrahedron", "5 triangles".
inline std::string counted(long long count, const CellShape &shape) {
  return std::to_string(count) + " " + (count == 1 ? shape.singular : shape.plural);
}

/// All rows.
std::span<const CellShape *const> all_shapes();
/// The shapes that a mesh may consist of.
std::span<const CellShape *const> mesh_shapes();

}  // namespace trefoil
