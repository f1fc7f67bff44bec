// The functions of trefoil.h that set up and ask an SNES, see their comments there.

#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

using trefoil::SolveContext;

PetscErrorCode TrefoilSNESSetSplitJacobian(SNES snes, Mat H, TrefoilSplitJacobianFunction function,
                                           void *ctx) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  PetscCall(trefoil::get_solve_context(snes, &context));
  context->split_jacobian = function;
  context->split_jacobian_context = ctx;
  PetscCall(trefoil::set_split_jacobian(*context, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetEnergyScale(SNES snes, TrefoilEnergyScaleFunction function,
                                         void *ctx) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  context->energy_scale = function;
  context->energy_scale_context = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetEnergyOffset(SNES snes, PetscReal offset) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCheck(!PetscIsInfOrNanReal(offset),
             PetscObjectComm(reinterpret_cast<PetscObject>(snes)), PETSC_ERR_ARG_OUTOFRANGE,
             "the energy offset is %g and must be finite", offset);
  PetscCall(trefoil::get_solve_context(snes, &context));
  context->energy_offset = offset;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetEnergyChanges(SNES snes, TrefoilEnergyChangesFunction function,
                                           void *ctx) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  context->energy_changes = function;
  context->energy_changes_context = ctx;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetWeight(SNES snes, PetscReal *weight) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  *weight = context->current.weight;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetTrustRegionRatio(SNES snes, PetscReal *rho) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  *rho = trefoil::IterationRecord::none;
  // A last entry without a step closes the history; the ratio belongs to the step before it.
  for (auto entry = context->history.rbegin(); entry != context->history.rend(); ++entry) {
    if (entry->step == 0) continue;
    *rho = entry->rho;
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetRecord(SNES snes, const char **json) {
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solve_context(snes, &context));
  *json = context->record.c_str();
  PetscFunctionReturn(PETSC_SUCCESS);
}
