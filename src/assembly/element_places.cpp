#include "assembly/element_places.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode make_element_places(const Mesh &mesh, const MatrixBlocks &blocks,
                                   ElementPlaces *places) {
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  PetscFunctionBeginUser;
  places->code.assign(width * mesh.cells.size(), ElementPlaces::nowhere);
  places->stride.assign(static_cast<std::size_t>(4 * mesh.local_vertices()), 0);
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    for (std::size_t a = 0; a < width; ++a) {
      const PetscInt row = mesh.cells[c + a];
      for (std::size_t b = 0; b < width; ++b) {
        BlockPlace place;
        PetscCall(blocks.place(row, mesh.cells[c + b], &places->numbers, &place));
        if (!place.exists()) continue;
        if (place.stride > 0) {
          places->stride[static_cast<std::size_t>(4 * row + (place.code & 3))] = place.stride;
        } else {
          place.code |= ElementPlaces::in_parts;
        }
        places->code[width * (c + a) + b] = place.code;
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
