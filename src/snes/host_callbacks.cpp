// The functions of trefoil.h by which a host tells what it knows of its energy, see their comments
// there.

#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"

using trefoil::Solver;

PetscErrorCode TrefoilSNESSetEnergyScale(SNES snes, TrefoilEnergyScaleFunction function,
                                         void *ctx) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->energy.scale_callback = {function, ctx};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetEnergyOffset(SNES snes, PetscReal offset) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCheck(!PetscIsInfOrNanReal(offset), PetscObjectComm(reinterpret_cast<PetscObject>(snes)),
             PETSC_ERR_ARG_OUTOFRANGE, "the energy offset is %g and must be finite", offset);
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->energy.offset = offset;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetEnergyChanges(SNES snes, TrefoilEnergyChangesFunction function,
                                           void *ctx) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->energy.changes_callback = {function, ctx};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetMaxStep(SNES snes, TrefoilMaxStepFunction function, void *ctx) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->energy.max_step_callback = {function, ctx};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetDirectionSize(SNES snes, TrefoilDirectionSizeFunction function,
                                           void *ctx) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->energy.direction_size_callback = {function, ctx};
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetMassProxy(SNES snes, TrefoilProxyFunction function, void *ctx) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->mass_proxy = {function, ctx};
  PetscFunctionReturn(PETSC_SUCCESS);
}
