#include "search/linear_failure.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Whether factors of the Jacobian did not fit into memory.
PetscErrorCode lacks_memory_for_factors(PC pc, PCFailedReason failure, bool *lacks) {
  PetscFunctionBeginUser;
  *lacks = failure == PC_FACTOR_OUTMEMORY;
#if defined(PETSC_HAVE_MUMPS)
  Mat factor = nullptr;
  MatSolverType package = nullptr;
  PetscBool mumps = PETSC_FALSE;
  if (failure != PC_FACTOR_OTHER) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatFactorGetSolverType(factor, &package));
  PetscCall(PetscStrcmp(package, MATSOLVERMUMPS, &mumps));
  if (mumps) {  // the code that PETSc knows nothing of: what a rank may allocate does not suffice
    PetscInt error = 0;
    PetscCall(MatMumpsGetInfog(factor, 1, &error));
    *lacks = error == -19;
  }
#else
  static_cast<void>(pc);
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode explain_linear_failure(KSP ksp, std::string *sentence) {
  KSPConvergedReason solved = KSP_CONVERGED_ITERATING;
  PCFailedReason failure = PC_NOERROR;
  PetscBool direct = PETSC_FALSE;
  PC pc = nullptr;
  bool lacks_memory = false;
  PetscFunctionBeginUser;
  PetscCall(KSPGetConvergedReason(ksp, &solved));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PCGetFailedReason(pc, &failure));
  PetscCall(lacks_memory_for_factors(pc, failure, &lacks_memory));
  if (lacks_memory) {
    *sentence =
        "the linear solver ran out of memory for its factors: an iterative one needs much less "
        "(-pc_type gamg), and more machines have more";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &direct));
  *sentence += std::string(" (") + KSPConvergedReasons[solved];
  if (failure) *sentence += std::string(", ") + PCFailedReasons[failure];
  *sentence += direct ? "): tune it by -pc_*, or take another"
                      : "): use a direct one, or tune it by -ksp_* and -pc_*";
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
