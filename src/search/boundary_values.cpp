#include "search/boundary_values.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode moves_boundary_values(Mat H, Vec direction, bool *moves) {
  Vec probe = nullptr, product = nullptr, diagonal = nullptr;
  PetscReal largest = 0;
  PetscInt size = 0;
  PetscFunctionBegin;
  PetscCall(VecDuplicate(direction, &probe));
  PetscCall(VecDuplicate(direction, &product));
  PetscCall(VecDuplicate(direction, &diagonal));
  PetscCall(MatGetDiagonal(H, diagonal));
  PetscCall(VecGetLocalSize(direction, &size));
  // (H z)_i = H_ii z_i for random z: row i has nothing beside its diagonal.
  std::vector<char> alone(static_cast<std::size_t>(size), 1);
  for (int k = 0; k < 2; ++k) {
    const PetscScalar *z = nullptr, *Hz = nullptr, *d = nullptr;
    PetscCall(VecSetRandom(probe, nullptr));
    PetscCall(MatMult(H, probe, product));
    PetscCall(VecGetArrayRead(probe, &z));
    PetscCall(VecGetArrayRead(product, &Hz));
    PetscCall(VecGetArrayRead(diagonal, &d));
    for (PetscInt i = 0; i < size; ++i) {
      const double own = PetscRealPart(d[i] * z[i]);
      if (!(std::abs(PetscRealPart(Hz[i]) - own) <= 1e-14 * std::abs(own))) {
        alone[static_cast<std::size_t>(i)] = 0;
      }
    }
    PetscCall(VecRestoreArrayRead(diagonal, &d));
    PetscCall(VecRestoreArrayRead(product, &Hz));
    PetscCall(VecRestoreArrayRead(probe, &z));
  }
  PetscCall(VecNorm(direction, NORM_INFINITY, &largest));
  double moved = 0;
  const PetscScalar *y = nullptr;
  PetscCall(VecGetArrayRead(direction, &y));
  for (PetscInt i = 0; i < size; ++i) {
    if (alone[static_cast<std::size_t>(i)]) moved = std::max(moved, std::abs(PetscRealPart(y[i])));
  }
  PetscCall(VecRestoreArrayRead(direction, &y));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &moved, 1, MPI_DOUBLE, MPI_MAX,
                             PetscObjectComm(reinterpret_cast<PetscObject>(H))));
  *moves = moved > 1e-9 * largest;
  PetscCall(VecDestroy(&probe));
  PetscCall(VecDestroy(&product));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
