#pragma once

#include <petscsystypes.h>

#include <map>
#include <string>
#include <vector>

#include "mesh/cell_shape.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {

/// A mesh as a mesher writes it: held whole, by one rank. Points live in space; the cells of a
/// plane mesh lie in z = 0. The vertices are the nodes of the elements: in a quadratic mesh the
/// midpoints of the edges are among them.
struct CellList {
  const CellShape *shape = &shapes::tet4;  ///< of all cells
  std::vector<double> coordinates;         ///< vertices x 3
  std::vector<PetscInt> cells;             ///< cells x nodes_per_cell(), 0-based vertex numbers
  std::vector<PetscInt> groups{};  ///< of each cell: its physical group, 0: none; empty: no cell's
  std::map<std::string, PetscInt> group_names{};  ///< of those groups that have one

  [[nodiscard]] int dimension() const { return shape->dimension; }
  [[nodiscard]] int corners() const { return shape->corners; }
  [[nodiscard]] int nodes_per_cell() const { return shape->nodes; }
  [[nodiscard]] PetscInt vertices() const { return static_cast<PetscInt>(coordinates.size()) / 3; }
  [[nodiscard]] PetscInt size() const {
    return static_cast<PetscInt>(cells.size()) / nodes_per_cell();
  }
};

}  // namespace trefoil
