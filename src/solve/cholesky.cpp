#include "solve/cholesky.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode set_cholesky(PC pc) {
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), &ranks));
  PetscCall(PCSetType(pc, PCCHOLESKY));
#if defined(PETSC_HAVE_SUITESPARSE)
  if (ranks == 1) PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERCHOLMOD));
#endif
#if defined(PETSC_HAVE_MUMPS)
  if (ranks > 1) PetscCall(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
