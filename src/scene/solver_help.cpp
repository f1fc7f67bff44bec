#include "scene/solver_help.hpp"

#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

void set_program_defaults(SolverOptions &options) {
  options.monitor = true;
  options.search = "subspace";
  options.verify_minimum = true;
}

PetscErrorCode print_solver_help(MPI_Comm comm) {
  SNES snes = nullptr;
  SolveContext *context = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESCreate(comm, &snes));
  PetscCall(SNESSetType(snes, SNESTREFOIL));
  PetscCall(get_solve_context(snes, &context));
  set_program_defaults(context->options);
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCCHOLESKY));
  PetscCall(SNESSetFromOptions(snes));  // which is what prints them
  PetscCall(SNESDestroy(&snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
