#pragma once

#include <petscsystypes.h>

#include <stdexcept>
#include <string>
#include <vector>

namespace trefoil {

/// What a user's input gets wrong, said in one sentence that names the culprit and the way out.
/// Thrown by code that knows no PETSc; whoever calls it from PETSc turns it into a PetscError.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A simplicial mesh as a mesher writes it: held whole, by one rank.
struct CellList {
  int dim = 3;                      ///< coordinates of a vertex, and dimension of the cells
  int corners = 4;                  ///< vertices of a cell (4: tetrahedron)
  std::vector<double> coordinates;  ///< vertices x dim
  std::vector<PetscInt> cells;      ///< cells x corners, 0-based vertex numbers

  [[nodiscard]] PetscInt vertices() const {
    return static_cast<PetscInt>(coordinates.size()) / dim;
  }
  [[nodiscard]] PetscInt size() const { return static_cast<PetscInt>(cells.size()) / corners; }
};

}  // namespace trefoil
