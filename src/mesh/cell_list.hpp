#pragma once

#include <petscsystypes.h>

#include <map>
#include <string>
#include <vector>

#include "support/input_error.hpp"

namespace trefoil {

/// A simplicial mesh as a mesher writes it: held whole, by one rank. Points live in space; the
/// cells of a plane mesh lie in z = 0.
///
/// The vertices are the nodes of the elements: with order 2 the midpoints of the edges are among
/// them. A cell names its corners first, then the midpoints of its edges (0,1) (1,2) (2,0), in a
/// tetrahedron also (0,3) (1,3) (2,3), as VTK and XDMF have it.
struct CellList {
  int dim = 3;                      ///< dimension of the cells: 3 tetrahedra, 2 triangles
  int order = 1;                    ///< 1: cells name their corners, 2: their edges' midpoints too
  std::vector<double> coordinates;  ///< vertices x 3
  std::vector<PetscInt> cells;      ///< cells x nodes_per_cell(), 0-based vertex numbers
  std::vector<PetscInt> groups{};   ///< of each cell: its physical group, 0: none; empty: no cell's
  std::map<std::string, PetscInt> group_names{};  ///< of those groups that have one

  [[nodiscard]] int corners() const { return dim + 1; }
  [[nodiscard]] int nodes_per_cell() const {
    return order == 1 ? corners() : corners() * (corners() + 1) / 2;
  }
  [[nodiscard]] PetscInt vertices() const { return static_cast<PetscInt>(coordinates.size()) / 3; }
  [[nodiscard]] PetscInt size() const {
    return static_cast<PetscInt>(cells.size()) / nodes_per_cell();
  }
};

/// "1 tetrahedron", "5 triangles".
inline std::string counted_cells(PetscInt count, int dim) {
  const char *names[] = {"triangle", "triangles", "tetrahedron", "tetrahedra"};
  return std::to_string(count) + " " + names[2 * (dim - 2) + (count == 1 ? 0 : 1)];
}

}  // namespace trefoil
