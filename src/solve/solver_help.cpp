#include "solve/solver_help.hpp"

#include "solve/solver_defaults.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {

PetscErrorCode print_solver_help(MPI_Comm comm) {
  SNES snes = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESCreate(comm, &snes));
  PetscCall(SNESSetType(snes, SNESTREFOIL));
  PetscCall(set_program_defaults(snes));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCSetType(pc, PCCHOLESKY));
  PetscCall(SNESSetFromOptions(snes));  // which is what prints them
  PetscCall(SNESDestroy(&snes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
