#pragma once

#include <string>
#include <vector>

#include "element/element_packs.hpp"
#include "mesh/mesh.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// Where -element_pressure is auto: constant for quadratic elements of which a material is nearly
/// incompressible, if all such materials split their volumetric part off and the filter is that of
/// elements; it has less error at the same time there. Says so where it is constant, and warns
/// where it is not though that would be better. Refuses a pressure that the elements, all materials
/// or the filter have not, in a sentence. Collective.
PetscErrorCode choose_element_pressure(const Mesh &mesh, SceneOptions *options,
                                       std::vector<std::string> *warnings);

/// What -element_pressure names; chosen.
ElementPressure element_pressure(const SceneOptions &options);

}  // namespace trefoil
