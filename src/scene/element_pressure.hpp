#pragma once

#include "element/element_packs.hpp"
#include "mesh/mesh.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// What -element_pressure names.
ElementPressure element_pressure(const SceneOptions &options);

/// Refuses a pressure that the elements, a material or the filter have not, in a sentence.
/// Collective.
/// @param model of `material`, the body's or a region's
PetscErrorCode check_element_pressure(const SceneOptions &options, const Mesh &mesh,
                                      const MaterialOptions &material, const MaterialModel &model);

}  // namespace trefoil
