#pragma once

#include <petscsystypes.h>

#include <map>
#include <string>
#include <vector>

#include "input_error.hpp"

namespace trefoil {

/// A simplicial mesh as a mesher writes it: held whole, by one rank.
struct CellList {
  int dim = 3;                      ///< coordinates of a vertex, and dimension of the cells
  int corners = 4;                  ///< vertices of a cell (4: tetrahedron)
  std::vector<double> coordinates;  ///< vertices x dim
  std::vector<PetscInt> cells;      ///< cells x corners, 0-based vertex numbers
  std::vector<PetscInt> groups{};   ///< of each cell: its physical group, 0: none; empty: no cell's
  std::map<std::string, PetscInt> group_names{};  ///< of those groups that have one

  [[nodiscard]] PetscInt vertices() const {
    return static_cast<PetscInt>(coordinates.size()) / dim;
  }
  [[nodiscard]] PetscInt size() const { return static_cast<PetscInt>(cells.size()) / corners; }
};

}  // namespace trefoil
