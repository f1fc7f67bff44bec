#pragma once

#include <string>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Removes the vertices that no cell names and renumbers the rest, whose order stays.
/// Returns how many went.
PetscInt drop_unused_vertices(CellList &mesh);

/// What to do about cells that have no usable rest shape.
enum class Repair {
  none,  ///< refuse the mesh
  drop   ///< leave them out
};

/// The cells without a usable rest shape, judged by their corners.
struct RestCheck {
  PetscInt degenerate =
      0;                  ///< |6 volume| <= 1e-14 (longest edge)^3: flat, or with a repeated vertex
  PetscInt negative = 0;  ///< of negative volume, and not degenerate
  PetscInt first = 0;     ///< 1-based number of the first of them in the order of cells; 0: none

  [[nodiscard]] PetscInt bad() const { return degenerate + negative; }
};

/// Counts them by the signed rest volume det(x1 - x0, x2 - x0, x3 - x0) / 6. Independent of the
/// unit of length, also where a volume would over- or underflow. Of triangles by area, likewise.
RestCheck check_rest_shape(const CellList &mesh);

/// Whether a cell is of negative volume, or runs clockwise.
bool is_turned_round(const CellList &mesh, PetscInt cell);

/// What repair_rest_shape() has done.
struct RepairReport {
  PetscInt turned = 0;   ///< tetrahedra: all that are not degenerate, or none
  PetscInt dropped = 0;  ///< cells without a usable rest shape
  PetscInt opened = 0;   ///< facets between a cell that was dropped and one that was not
};

/// Checks the rest shape and, with Repair::drop, removes what is bad (vertices stay, see
/// drop_unused_vertices). A plane mesh must lie in z = 0; its triangles are turned anticlockwise,
/// and tetrahedra are turned round where all of them are the other way round. With Repair::none any
/// bad cell, and always a mesh of which nothing is left, is an InputError that calls the mesh
/// `name`.
RepairReport repair_rest_shape(CellList &mesh, Repair repair, const std::string &name);

/// Refuses quadratic cells whose midpoints lie on each other's edges, as in a file that has the
/// nodes in another program's order. InputError that calls the mesh `name`.
void check_node_order(const CellList &mesh, const std::string &name);

/// Moves the mean of the vertices to the origin and scales the farthest vertex to distance 1, which
/// makes coordinates dimensionless. InputError if all vertices coincide or there are none.
void normalize(CellList &mesh);

}  // namespace trefoil
