#include "search/boundary_values.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "hook/matrix_operations.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Rows of this rank with nothing beside their diagonal: (H z)_i = H_ii z_i for random z.
PetscErrorCode find_lone_rows(Mat H, Vec like, std::vector<char> *alone) {
  Vec probe = nullptr, product = nullptr, diagonal = nullptr;
  PetscFunctionBegin;
  PetscCall(VecDuplicate(like, &probe));
  PetscCall(VecDuplicate(like, &product));
  PetscCall(VecDuplicate(like, &diagonal));
  PetscCall(MatGetDiagonal(H, diagonal));
  for (int k = 0; k < 2; ++k) {
    const PetscScalar *z = nullptr, *Hz = nullptr, *d = nullptr;
    PetscCall(VecSetRandom(probe, nullptr));
    PetscCall(MatMult(H, probe, product));
    PetscCall(VecGetArrayRead(probe, &z));
    PetscCall(VecGetArrayRead(product, &Hz));
    PetscCall(VecGetArrayRead(diagonal, &d));
    for (std::size_t i = 0; i < alone->size(); ++i) {
      const double own = PetscRealPart(d[i] * z[i]);
      if (!(std::abs(PetscRealPart(Hz[i]) - own) <= 1e-14 * std::abs(own))) (*alone)[i] = 0;
    }
    PetscCall(VecRestoreArrayRead(diagonal, &d));
    PetscCall(VecRestoreArrayRead(product, &Hz));
    PetscCall(VecRestoreArrayRead(probe, &z));
  }
  PetscCall(VecDestroy(&probe));
  PetscCall(VecDestroy(&product));
  PetscCall(VecDestroy(&diagonal));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Of these rows the ones that the direction moves; whether any rank has one.
PetscErrorCode keep_moved(Vec d, std::vector<char> *rows, bool *any) {
  const PetscScalar *y = nullptr;
  PetscReal largest = 0;
  int found = 0;
  PetscFunctionBegin;
  PetscCall(VecNorm(d, NORM_INFINITY, &largest));
  PetscCall(VecGetArrayRead(d, &y));
  for (std::size_t i = 0; i < rows->size(); ++i) {
    (*rows)[i] = (*rows)[i] && std::abs(PetscRealPart(y[i])) > 1e-9 * largest;
    if ((*rows)[i]) found = 1;
  }
  PetscCall(VecRestoreArrayRead(d, &y));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_LOR,
                             PetscObjectComm(reinterpret_cast<PetscObject>(d))));
  *any = found != 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether a full step takes the residual of any of these rows away, on any rank.
PetscErrorCode full_step_meets(LineSearchState &state, const std::vector<char> &rows, bool *meets) {
  const PetscScalar *before = nullptr, *after = nullptr;
  int found = 0;
  PetscFunctionBegin;
  PetscCall(VecWAXPY(state.trial, 1, state.d, state.x));
  PetscCall(state.f.gradient(state.trial, state.trial_residual));
  PetscCall(VecGetArrayRead(state.residual, &before));
  PetscCall(VecGetArrayRead(state.trial_residual, &after));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double left = std::abs(PetscRealPart(after[i])), was = std::abs(PetscRealPart(before[i]));
    if (rows[i] && left <= 1e-3 * was) found = 1;
  }
  PetscCall(VecRestoreArrayRead(state.trial_residual, &after));
  PetscCall(VecRestoreArrayRead(state.residual, &before));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &found, 1, MPI_INT, MPI_LOR,
                             PetscObjectComm(reinterpret_cast<PetscObject>(state.x))));
  *meets = found != 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode moves_boundary_values(Mat H, LineSearchState &state, std::vector<char> *held,
                                     bool *moves) {
  PetscInt size = 0;
  PetscFunctionBegin;
  *moves = false;
  if (is_matrix_free(H)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetLocalSize(state.d, &size));
  held->assign(static_cast<std::size_t>(size), 1);
  PetscCall(find_lone_rows(H, state.d, held));
  std::vector<char> rows = *held;
  PetscCall(keep_moved(state.d, &rows, moves));
  if (*moves) PetscCall(full_step_meets(state, rows, moves));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
