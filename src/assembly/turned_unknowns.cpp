#include "assembly/discretization.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

// Unknowns of turned vertices: y = R'u in place of u, R orthogonal. Those that are held stay in the
// system with a row of their own, zero but on the diagonal, so that its pattern and its blocks are
// those of free vertices.

PetscErrorCode Discretization::turn_to_space(Vec local, bool prescribes) const {
  PetscScalar *u = nullptr;
  PetscFunctionBeginUser;
  if (!any_turned_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecGetArray(local, &u));
  for (const TurnedVertex &turned : turned_) {
    double *at = u + 3 * turned.vertex;
    for (int k = 0; k < turned.held; ++k) {
      at[k] = prescribes ? turned.values[static_cast<std::size_t>(k)] : 0;
    }
    turned.to_space(at);
  }
  PetscCall(VecRestoreArray(local, &u));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Discretization::turn_to_axes(double *values) const {
  for (const TurnedVertex &turned : turned_) {
    double *at = values + 3 * turned.vertex;
    turned.to_axes(at);
    for (int k = 0; k < turned.held; ++k) at[k] = 0;
  }
}

/// R, with a row a unknown; and the held ones that this rank owns.
PetscErrorCode Discretization::make_rotation(Mat like) const {
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  if (rotation_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatGetOwnershipRange(like, &begin, &end));
  PetscCall(MatCreateAIJ(PetscObjectComm(reinterpret_cast<PetscObject>(like)), end - begin,
                         end - begin, PETSC_DETERMINE, PETSC_DETERMINE, 3, nullptr, 0, nullptr,
                         &rotation_));
  std::vector<char> is_turned(static_cast<std::size_t>(end - begin), 0);
  const PetscInt dim = mesh_->dimension();
  for (const TurnedVertex &turned : turned_) {
    const std::array<PetscInt, 3> dofs = dofs_of_vertex(turned.vertex);
    if (dofs[0] < begin || dofs[0] >= end) continue;
    for (PetscInt i = 0; i < dim; ++i) {
      for (PetscInt k = 0; k < dim; ++k) {
        const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(k);
        PetscCall(MatSetValue(rotation_, dofs[row], dofs[column], turned.axes[column][row],
                              INSERT_VALUES));
      }
      is_turned[static_cast<std::size_t>(dofs[static_cast<std::size_t>(i)] - begin)] = 1;
      if (i < turned.held) held_rows_.push_back(dofs[static_cast<std::size_t>(i)]);
    }
  }
  for (PetscInt row = begin; row < end; ++row) {
    if (is_turned[static_cast<std::size_t>(row - begin)]) continue;
    PetscCall(MatSetValue(rotation_, row, row, 1, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(rotation_, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(rotation_, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::turn_matrix(Mat matrix, bool has_diagonal) const {
  Mat turned = nullptr;
  Vec diagonal = nullptr;
  PetscReal size = 0;
  MatNullSpace modes = nullptr;
  PetscFunctionBeginUser;
  if (!any_turned_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(make_rotation(matrix));
  // MatCopy() between different patterns loses them.
  PetscCall(MatGetNearNullSpace(matrix, &modes));
  PetscCall(PetscObjectReference(reinterpret_cast<PetscObject>(modes)));
  PetscCall(MatPtAP(matrix, rotation_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, &turned));
  PetscCall(MatCopy(turned, matrix, DIFFERENT_NONZERO_PATTERN));
  PetscCall(MatDestroy(&turned));
  PetscCall(MatSetNearNullSpace(matrix, modes));
  PetscCall(MatNullSpaceDestroy(&modes));
  if (has_diagonal) {
    PetscCall(MatCreateVecs(matrix, &diagonal, nullptr));
    PetscCall(MatGetDiagonal(matrix, diagonal));
    PetscCall(VecNorm(diagonal, NORM_INFINITY, &size));
    PetscCall(VecDestroy(&diagonal));
    if (size == 0) size = 1;
  }
  PetscCall(MatSetOption(matrix, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
  PetscCall(MatZeroRowsColumns(matrix, static_cast<PetscInt>(held_rows_.size()), held_rows_.data(),
                               size, nullptr, nullptr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
