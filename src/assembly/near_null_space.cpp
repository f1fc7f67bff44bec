#include "assembly/near_null_space.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode attach_near_null_space(Mat matrix, std::vector<Vec> *modes) {
  std::vector<Vec> kept;
  MatNullSpace space = nullptr;
  PetscFunctionBeginUser;
  for (Vec mode : *modes) {
    PetscReal before = 0, after = 0;
    PetscCall(VecNorm(mode, NORM_2, &before));
    for (Vec other : kept) {
      PetscScalar overlap = 0;
      PetscCall(VecDot(mode, other, &overlap));
      PetscCall(VecAXPY(mode, -overlap, other));
    }
    PetscCall(VecNormalize(mode, &after));
    // Free vertices on one line, say, know fewer than six rigid-body modes.
    if (after > 1e-8 * before) kept.push_back(mode);
  }
  PetscCall(MatNullSpaceCreate(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), PETSC_FALSE,
                               static_cast<PetscInt>(kept.size()), kept.data(), &space));
  PetscCall(MatSetNearNullSpace(matrix, space));
  PetscCall(MatNullSpaceDestroy(&space));
  for (Vec &mode : *modes) PetscCall(VecDestroy(&mode));
  modes->clear();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
