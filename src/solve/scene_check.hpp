#pragma once

#include "scene/scene.hpp"

namespace trefoil {

/// Prints what a scene that build_scene() has made holds, and what its solve would take: groups,
/// moments of the loads, regions, materials with their constants, load steps, solver and memory.
/// Solves nothing; a direct solver's factor is analysed for its size. Collective.
PetscErrorCode print_scene_check(Scene &scene);

}  // namespace trefoil
