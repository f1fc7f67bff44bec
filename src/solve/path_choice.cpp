#include "solve/path_choice.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode may_take_path(const SceneOptions &options, bool *may) {
  PetscFunctionBeginUser;
  *may = options.initial == "auto";
  for (const char *option : {"-load_steps", "-snes_type"}) {
    PetscBool is_given = PETSC_FALSE;
    PetscCall(PetscOptionsHasName(nullptr, nullptr, option, &is_given));
    *may = *may && !is_given;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
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
