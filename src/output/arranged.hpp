#pragma once

#include <petscsystypes.h>

#include <string>
#include <vector>

#include "mesh/cell_shape.hpp"

namespace trefoil {

/// This rank's share of a mesh as the file has it: rows in their final order, rank below rank.
struct ArrangedMesh {
  const CellShape *shape = &shapes::tet4;
  PetscInt total_points = 0, total_cells = 0;  ///< of all ranks
  PetscInt first_point = 0, first_cell = 0;    ///< where this rank's share begins
  std::vector<double> points;                  ///< share of the vertices x 3
  std::vector<PetscInt> cells;                 ///< share of the cells x nodes, places of vertices
  std::vector<std::string> obstacles{};        ///< see OutputMesh
};

/// What a field is called and what it is, which all ranks know.
struct FieldKind {
  std::string name;
  bool on_vertices = true;
  int components = 1;
};

/// This rank's share of a field.
struct ArrangedField : FieldKind {
  std::vector<double> values;
};

}  // namespace trefoil
