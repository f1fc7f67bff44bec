#include <petscksp.h>

#include <cmath>

#include "petsc_compatibility.hpp"
#include "snes/line.hpp"

namespace trefoil {
namespace {

/// Factors of a symmetric matrix tell how many eigenvalues are negative; -1 where nobody counted.
PetscErrorCode negative_pivots(SNES snes, PetscInt *count) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  PetscBool cholesky = PETSC_FALSE;
  PetscFunctionBegin;
  *count = -1;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
#if defined(PETSC_HAVE_MUMPS)
  if (cholesky) {
    Mat factor = nullptr;
    MatSolverType solver = nullptr;
    PetscBool mumps = PETSC_FALSE;
    PetscCall(PCFactorGetMatrix(pc, &factor));
    PetscCall(MatFactorGetSolverType(factor, &solver));
    PetscCall(PetscStrcmp(solver, MATSOLVERMUMPS, &mumps));
    if (mumps) PetscCall(MatMumpsGetInfog(factor, 12, count));
  }
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode judge_direction(SolveContext &context, const Line &line,
                               SNESConvergedReason *reason) {
  const bool unfiltered = context.current.weight < 0.5;
  PetscInt negative = -1;
  PetscFunctionBegin;
  *reason = SNES_CONVERGED_ITERATING;
  if (!std::isfinite(line.slope) || !std::isfinite(context.current.energy)) {
    context.summary.reason = "the energy or the direction is not finite";
    *reason = SNES_DIVERGED_FNORM_NAN;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  // Newton's plain direction from an indefinite Hessian may descend by luck; it is none to follow.
  if (unfiltered) PetscCall(negative_pivots(context.snes, &negative));
  if (negative > 0 || (line.slope > 0 && !line.lifted)) {
    context.summary.reason =
        unfiltered ? "the Hessian is indefinite and the filter leaves it so; filter adaptive, "
                     "absolute or clamp do not"
                   : "the direction ascends: the linear solve is too inexact or the residual is no "
                     "gradient of the objective";
    *reason = SNES_DIVERGED_LINEAR_SOLVE;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
