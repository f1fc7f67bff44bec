// The functions of trefoil.h for callbacks that split the Hessian themselves.

#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"

using trefoil::Solver;

PetscErrorCode TrefoilSNESSetSplitJacobian(SNES snes, Mat H, TrefoilSplitJacobianFunction function,
                                           void *ctx) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->split_jacobian = {{function, ctx}, 0, {}};
  PetscCall(trefoil::install_split_jacobian(*solver, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetSplitCapabilities(SNES snes, int capabilities) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  PetscCheck(solver->split_jacobian, PetscObjectComm(reinterpret_cast<PetscObject>(snes)),
             PETSC_ERR_ORDER, "call TrefoilSNESSetSplitJacobian() first");
  solver->split_jacobian.capabilities = capabilities;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetEigenvalueFloor(SNES snes, PetscReal *share, PetscReal *weight) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  const trefoil::EigenvalueFloor floor = solver->floor(solver->record.current.weight);
  *share = floor.share;
  *weight = floor.weight;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetHessianProduct(SNES snes, TrefoilHessianProductFunction function,
                                            void *ctx) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  PetscCheck(solver->split_jacobian, PetscObjectComm(reinterpret_cast<PetscObject>(snes)),
             PETSC_ERR_ORDER, "call TrefoilSNESSetSplitJacobian() first");
  solver->split_jacobian.product = {function, ctx};
  PetscFunctionReturn(PETSC_SUCCESS);
}
