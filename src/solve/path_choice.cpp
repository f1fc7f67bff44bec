#include "solve/path_choice.hpp"

#include "solve/loose_path.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {

PetscErrorCode may_take_path(const SceneOptions &options, bool *may) {
  PetscBool has_steps = PETSC_FALSE, has_type = PETSC_FALSE, is_ours = PETSC_FALSE;
  char type[256];
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-load_steps", &has_steps));
  PetscCall(PetscOptionsGetString(nullptr, nullptr, "-snes_type", type, sizeof type, &has_type));
  if (has_type) PetscCall(PetscStrcmp(type, SNESTREFOIL, &is_ours));
  *may = options.initial == "auto" && !has_steps && (!has_type || is_ours);
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool is_hard(PetscInt64 inverted_at_start, const Scene &scene) {
  constexpr double hard_share = 0.005;
  return is_above(inverted_at_start, hard_share, scene);
}

PetscErrorCode goes_own_way(Scene &scene, bool *own) {
  bool loads_have = false;
  PetscFunctionBeginUser;
  PetscCall(scene.constraints.have_own_way(own));
  PetscCall(scene.loads.have_own_way(&loads_have));
  *own = *own || loads_have;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
