#include <algorithm>

#include "assembly/discretization.hpp"
#include "petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Adds each row's number of entries to `counts`.
PetscErrorCode add_row_lengths(Mat matrix, std::vector<PetscInt> *counts) {
  PetscInt rows = 0;
  const PetscInt *start = nullptr, *column = nullptr;
  PetscBool done = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &rows, &start, &column, &done));
  counts->resize(static_cast<std::size_t>(rows));
  for (PetscInt r = 0; r < rows; ++r) {
    (*counts)[static_cast<std::size_t>(r)] = start[r + 1] - start[r];
  }
  PetscCall(MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &rows, &start, &column, &done));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

/// Neighbours of each owned vertex, itself included: on this rank and on others. PETSc's coordinate
/// format finds them from the cells' pairs of corners, those of other ranks' cells included.
PetscErrorCode Discretization::count_row_entries(std::vector<PetscInt> *diagonal,
                                                 std::vector<PetscInt> *off_diagonal) const {
  const Mesh &mesh = *mesh_;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  Mat neighbours = nullptr, here = nullptr, elsewhere = nullptr;
  PetscBool sequential = PETSC_FALSE;
  PetscFunctionBeginUser;
  std::vector<PetscInt> row, column;
  row.reserve(4 * mesh.cells.size());
  column.reserve(4 * mesh.cells.size());
  for (std::size_t c = 0; c + 3 < mesh.cells.size(); c += 4) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        row.push_back(mesh.global_vertex[static_cast<std::size_t>(mesh.cells[c + a])]);
        column.push_back(mesh.global_vertex[static_cast<std::size_t>(mesh.cells[c + b])]);
      }
    }
  }
  const auto owned =
      static_cast<PetscInt>(std::count(mesh.owned.begin(), mesh.owned.end(), 1));
  PetscCall(MatCreate(comm, &neighbours));
  PetscCall(MatSetSizes(neighbours, owned, owned, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(neighbours, MATAIJ));
  PetscCall(MatSetPreallocationCOO(neighbours, static_cast<PetscCount>(row.size()), row.data(),
                                   column.data()));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(neighbours), MATSEQAIJ,
                                   &sequential));
  if (sequential) {
    PetscCall(add_row_lengths(neighbours, diagonal));
    off_diagonal->assign(diagonal->size(), 0);
  } else {
    PetscCall(MatMPIAIJGetSeqAIJ(neighbours, &here, &elsewhere, nullptr));
    PetscCall(add_row_lengths(here, diagonal));
    PetscCall(add_row_lengths(elsewhere, off_diagonal));
  }
  PetscCall(MatDestroy(&neighbours));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::create_matrix(Mat *matrix) const {
  const Mesh &mesh = *mesh_;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  Vec layout = nullptr;
  PetscInt rows = 0;
  std::vector<PetscInt> diagonal, off_diagonal, row_diagonal, row_off_diagonal;
  PetscFunctionBeginUser;
  PetscCall(count_row_entries(&diagonal, &off_diagonal));
  // Room for all three columns of every neighbour; columns of held dofs go when it is assembled.
  std::size_t vertex = 0;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    for (std::size_t i = 0; i < 3; i += static_cast<std::size_t>(block_size_)) {
      if (global_dofs_[3 * v + i] < 0) continue;
      const PetscInt columns = 3 / block_size_;
      row_diagonal.push_back(columns * diagonal[vertex]);
      row_off_diagonal.push_back(columns * off_diagonal[vertex]);
    }
    ++vertex;
  }
  PetscCall(DMGetGlobalVector(mesh.dm, &layout));
  PetscCall(VecGetLocalSize(layout, &rows));
  PetscCall(DMRestoreGlobalVector(mesh.dm, &layout));
  // No row can hold more entries than the matrix has columns.
  for (auto &count : row_diagonal) count = std::min(count, rows / block_size_);
  for (auto &count : row_off_diagonal) count = std::min(count, (total_ - rows) / block_size_);
  PetscCall(MatCreate(comm, matrix));
  PetscCall(MatSetSizes(*matrix, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetBlockSize(*matrix, block_size_));
  PetscCall(MatSetType(*matrix, MATAIJ));
  PetscCall(MatXAIJSetPreallocation(*matrix, block_size_, row_diagonal.data(),
                                    row_off_diagonal.data(), nullptr, nullptr));
  PetscCall(MatSetOption(*matrix, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(*matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  PetscCall(attach_rigid_body_modes(*matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

double rigid_body_mode(int m, int i, const double *p, const std::array<double, 3> &centre) {
  if (m < 3) return m == i ? 1 : 0;
  const int axis = m - 3, next = (axis + 1) % 3, after = (axis + 2) % 3;
  // e_axis x (p - centre)
  if (i == after) return p[next] - centre[static_cast<std::size_t>(next)];
  if (i == next) return -(p[after] - centre[static_cast<std::size_t>(after)]);
  return 0;
}

/// Algebraic multigrid needs to know what costs no elastic energy.
PetscErrorCode Discretization::attach_rigid_body_modes(Mat matrix) const {
  const Mesh &mesh = *mesh_;
  Vec local = nullptr;
  std::vector<Vec> modes;
  MatNullSpace space = nullptr;
  std::array<double, 3> centre{};
  PetscFunctionBeginUser;
  for (std::size_t i = 0; i < 3; ++i) centre[i] = 0.5 * (mesh.box_min[i] + mesh.box_max[i]);
  PetscCall(DMGetLocalVector(mesh.dm, &local));
  for (int m = 0; m < 6; ++m) {
    PetscScalar *value = nullptr;
    PetscReal before = 0, after = 0;
    Vec mode = nullptr;
    PetscCall(VecGetArrayWrite(local, &value));
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      for (int i = 0; i < 3; ++i) {
        value[3 * v + static_cast<std::size_t>(i)] =
            rigid_body_mode(m, i, &mesh.coordinates[3 * v], centre);
      }
    }
    PetscCall(VecRestoreArrayWrite(local, &value));
    PetscCall(create_vector(&mode));
    PetscCall(DMLocalToGlobal(mesh.dm, local, INSERT_VALUES, mode));
    PetscCall(VecNorm(mode, NORM_2, &before));
    for (Vec other : modes) {
      PetscScalar overlap = 0;
      PetscCall(VecDot(mode, other, &overlap));
      PetscCall(VecAXPY(mode, -overlap, other));
    }
    PetscCall(VecNormalize(mode, &after));
    // Free vertices on one line, say, know fewer than six modes.
    if (after > 1e-8 * before) {
      modes.push_back(mode);
    } else {
      PetscCall(VecDestroy(&mode));
    }
  }
  PetscCall(DMRestoreLocalVector(mesh.dm, &local));
  PetscCall(MatNullSpaceCreate(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), PETSC_FALSE,
                               static_cast<PetscInt>(modes.size()), modes.data(), &space));
  PetscCall(MatSetNearNullSpace(matrix, space));
  PetscCall(MatNullSpaceDestroy(&space));
  for (Vec &mode : modes) PetscCall(VecDestroy(&mode));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
