#include "hook/matrix_operations.hpp"
#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Also of a matrix that has not been assembled yet.
PetscErrorCode set_identity(Mat matrix) {
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(matrix));
  PetscCall(MatGetOwnershipRange(matrix, &begin, &end));
  for (PetscInt row = begin; row < end; ++row) {
    PetscCall(MatSetValue(matrix, row, row, 1, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode form_proxy(Solver &solver, Mat J, Mat H) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes));
  SolveRecord &record = solver.record;
  InsertionCounts nothing_seen;
  PetscFunctionBeginUser;
  record.current.indefinite = IterationRecord::none;
  if (solver.proxy_is_formed) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(J == H && !is_matrix_free(H), comm, PETSC_ERR_SUP,
             "-snes_trefoil_proxy needs an assembled Jacobian, one matrix for both");
  if (solver.options.search.proxy == TREFOIL_PROXY_MASS) {
    const auto &mass = solver.mass_proxy;
    PetscCheck(mass, comm, PETSC_ERR_USER_INPUT,
               "-snes_trefoil_proxy mass: nothing here has a mass; it is for steps in time, or "
               "give a matrix with TrefoilSNESSetMassProxy()");
    PetscCall(mass.function(solver.snes, H, mass.context));
  } else {
    PetscCall(set_identity(H));
  }
  PetscCall(MatSetOption(H, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(H, MAT_SPD, PETSC_TRUE));
  // As good as clamped: it is positive definite.
  PetscCall(solver.jacobian.form(H, 1, false, nothing_seen));
  solver.proxy_is_formed = true;
  record.clock.switch_to(Phase::linear_solve);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
