#pragma once

#include "assembly/matrix_blocks.hpp"
#include "element/element_packs.hpp"

namespace trefoil {

/// Finds where the blocks of all cells go. Call while `blocks` is being placed.
PetscErrorCode make_element_places(const Mesh &mesh, const MatrixBlocks &blocks,
                                   ElementPlaces *places);

}  // namespace trefoil
