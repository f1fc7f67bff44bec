#pragma once

#include "scene/scene.hpp"

namespace trefoil {

/// Refuses a start whose energy is not finite, which no search can lead away from: the sentence
/// counts the elements, says where the first one lies, and names the ways out. Refuses also options
/// of the line search and of the starting guess that nothing has used on the way here. Collective.
PetscErrorCode check_start(const Scene &scene, double energy);

}  // namespace trefoil
