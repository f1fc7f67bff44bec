#pragma once

#include <petscsys.h>

#include <vector>

namespace trefoil {

struct Scene;

/// Reads obstacles, finds the surface, and adds the term of contact to the scene's energy.
/// Collective. Errors, one sentence on all ranks: quadratic cells, an assembly that knows no
/// largest step, bodies and obstacles that meet at rest or nearly touch. The contact distance is
/// lowered, and that is printed, where something is nearer at rest.
PetscErrorCode add_contact(const std::vector<int> &region_of_cell, Scene *scene);

}  // namespace trefoil
