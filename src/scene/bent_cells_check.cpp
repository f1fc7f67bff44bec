#include "scene/bent_cells_check.hpp"

#include "element/bent_cells.hpp"

namespace trefoil {

void check_bent_cells(const CellList &mesh, const std::string &name) {
  if (!is_quadratic(*mesh.shape)) return;
  const PetscInt bent = first_bent_cell(reference_element(mesh.dimension(), mesh.nodes_per_cell()),
                                        mesh.coordinates, mesh.cells);
  if (bent >= 0)
    throw InputError(name + ": " + name_of_cell(mesh, bent) +
                     " is bent so far that its Jacobian determinant is not positive at a "
                     "quadrature point; mend the mesh, or use its corners only with -order 1");
}

}  // namespace trefoil
