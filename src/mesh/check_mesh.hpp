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

/// Checks the rest shape and, with Repair::drop, removes what is bad (vertices stay, see
/// drop_unused_vertices). A plane mesh must lie in z = 0; its triangles are turned anticlockwise.
/// Returns how many cells went. With Repair::none any of them, and
/// always a mesh of which nothing is left, is an InputError that calls the mesh `name`.
PetscInt repair_rest_shape(CellList &mesh, Repair repair, const std::string &name);

/// Moves the mean of the vertices to the origin and scales the farthest vertex to distance 1, which
/// makes coordinates dimensionless. InputError if all vertices coincide or there are none.
void normalize(CellList &mesh);

}  // namespace trefoil
