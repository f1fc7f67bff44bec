#pragma once

#include <array>
#include <string>
#include <vector>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// Where a body is put: scaled about the origin, turned about an axis through it, then moved.
struct Placement {
  double scale = 1;
  std::array<double, 3> axis{0, 0, 1};
  double degrees = 0;
  std::array<double, 3> shift{};
};

/// One of several bodies: where it comes from and where it is put.
struct BodySource {
  std::string name;
  std::string file = {}, generate = {};  ///< one of them
  PetscInt resolution = 0;               ///< of a generated one
  Placement placement = {};
};

/// Moves all vertices; the axis is no null vector.
void place(CellList &mesh, const Placement &placement);

/// Makes one mesh of several, which share no vertex: vertices and cells of the second come behind
/// those of the first, also by their files' numbers. Groups remain those of their bodies; all cells
/// of a body are a group more, which has its name.
/// @param bodies one for each mesh
/// @throws InputError where their cells are of different kinds, or too many
CellList join_bodies(const std::vector<CellList> &meshes, const std::vector<BodySource> &bodies);

/// "low, middle and high"
std::string names_of(const std::vector<BodySource> &bodies);

}  // namespace trefoil
