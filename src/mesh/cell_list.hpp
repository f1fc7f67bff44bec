#pragma once

#include <petscsystypes.h>

#include <string>
#include <vector>

#include "mesh/cell_shape.hpp"
#include "mesh/groups.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {

/// One of several bodies of a mesh: its file's vertices have these numbers, from `first_vertex` on.
struct BodyNumbers {
  std::string name;
  PetscInt first_vertex = 0;
};

/// A mesh as a mesher writes it: held whole, by one rank. Points live in space; the cells of a
/// plane mesh lie in z = 0. The vertices are the nodes of the elements: in a quadratic mesh the
/// midpoints of the edges are among them.
struct CellList {
  const CellShape *shape = &shapes::tet4;  ///< of all cells
  std::vector<double> coordinates;         ///< vertices x 3
  std::vector<PetscInt> cells;             ///< cells x nodes_per_cell(), 0-based vertex numbers
  Groups groups{};
  /// Of each vertex and cell, where it came in the file, 0-based; what the file has not comes
  /// behind all that it has, with a number of its own. Empty: as they stand.
  std::vector<PetscInt> vertex_number{}, cell_number{};
  PetscInt file_vertices = 0;         ///< vertices of the file, where they are numbered
  PetscInt file_cells = 0;            ///< likewise
  std::vector<BodyNumbers> bodies{};  ///< of several files; see join_bodies()

  [[nodiscard]] int dimension() const { return shape->dimension; }
  [[nodiscard]] int corners() const { return shape->corners; }
  [[nodiscard]] int nodes_per_cell() const { return shape->nodes; }
  [[nodiscard]] PetscInt vertices() const { return static_cast<PetscInt>(coordinates.size()) / 3; }
  [[nodiscard]] PetscInt size() const {
    return static_cast<PetscInt>(cells.size()) / nodes_per_cell();
  }
};

/// "tetrahedron 7": a cell as the user may count it, from 1 in the file's order.
std::string name_of_cell(const CellList &mesh, PetscInt cell);

/// Notes where vertices and cells stand now; all that follows takes these numbers along.
void number_as_in_file(CellList &mesh);

/// Gives vertices new numbers, 0 ... count - 1, and leaves out those with -1, which no cell may
/// use; what groups have of them goes too.
void renumber_vertices(CellList &mesh, const std::vector<PetscInt> &new_number, PetscInt count);

/// Keeps these cells, in this order.
void keep_cells(CellList &mesh, const std::vector<PetscInt> &order);

}  // namespace trefoil
