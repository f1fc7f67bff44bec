#pragma once

#include "scene/scene.hpp"

namespace trefoil {

/// Whether a scene may be led on a path of the program's own accord: unless the user says from
/// where (-initial other than auto), in what steps (-load_steps) or by what other than ours
/// (-snes_type) it is solved. Collective.
PetscErrorCode may_take_path(const SceneOptions &options, bool *may);

/// Whether a scene is hard: by the elements that the guess of a leap inverts.
bool is_hard(PetscInt64 inverted_at_start, const Scene &scene);

/// Whether what is written in t goes another way than the program would lead it, so that its end
/// alone does not say where it leads. Collective.
PetscErrorCode goes_own_way(Scene &scene, bool *own);

}  // namespace trefoil
