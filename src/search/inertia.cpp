#include "search/inertia.hpp"

#include <petsc/private/pcimpl.h>

#include <array>
#include <string>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode try_to_factor(PC solver, PetscErrorCode *failure) {
  PetscBool lagged = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(PCGetReusePreconditioner(solver, &lagged));
  PetscCall(PCSetReusePreconditioner(solver, PETSC_FALSE));
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  *failure = PCSetUp(solver);
  PetscCall(PetscPopErrorHandler());
  PetscCall(PCSetReusePreconditioner(solver, lagged));
  // The next set-up would begin anew, with what the first, unfinished one has left behind.
  if (*failure && !solver->setupcalled) PetscCall(PCReset(solver));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode raises_indefiniteness(KSP ksp, bool *raises) {
  PC pc = nullptr;
  MatSolverType solver = nullptr;
  PetscBool cholesky = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
  if (cholesky) PetscCall(PCFactorGetMatSolverType(pc, &solver));
  *raises = solver && std::string(solver) == MATSOLVERCHOLMOD;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode inertia_of_factors(KSP ksp, Inertia *inertia) {
  PC pc = nullptr;
  Mat factor = nullptr;
  MatSolverType solver = nullptr;
  PetscBool cholesky = PETSC_FALSE, mumps = PETSC_FALSE, cholmod = PETSC_FALSE;
  PetscFunctionBegin;
  *inertia = Inertia::unknown;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
  if (!cholesky) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatFactorGetSolverType(factor, &solver));
  PetscCall(PetscStrcmp(solver, MATSOLVERMUMPS, &mumps));
  PetscCall(PetscStrcmp(solver, MATSOLVERCHOLMOD, &cholmod));
  if (cholmod) {
    // Supernodal factors exist for definite matrices only; simplicial ones, which it prefers for
    // small matrices, exist for others as well.
    PetscOptions database = nullptr;
    const char *prefix = nullptr;
    std::array<char, 32> kind{};
    PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(factor), &database));
    PetscCall(MatGetOptionsPrefix(factor, &prefix));
    PetscCall(PetscOptionsGetString(database, prefix, "-mat_cholmod_factor", kind.data(),
                                    kind.size(), nullptr));
    if (std::string(kind.data()) == "SUPERNODAL") *inertia = Inertia::definite;
  }
#if defined(PETSC_HAVE_MUMPS)
  Mat matrix = nullptr;
  PetscBool known = PETSC_FALSE, definite = PETSC_FALSE;
  PetscCall(KSPGetOperators(ksp, nullptr, &matrix));
  PetscCall(MatIsSPDKnown(matrix, &known, &definite));
  // Told that a matrix is positive definite, it counts no pivots.
  if (mumps && !(known && definite)) {
    PetscInt error = 0, negative = 0;
    PetscCall(MatMumpsGetInfog(factor, 1, &error));
    PetscCall(MatMumpsGetInfog(factor, 12, &negative));
    *inertia = error >= 0 && negative == 0 ? Inertia::definite : Inertia::indefinite;
  }
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
