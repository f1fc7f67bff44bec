#include "search/inertia.hpp"

#include <petsc/private/pcimpl.h>

#include <array>
#include <string>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Supernodal factors exist for definite matrices only; simplicial ones, which CHOLMOD prefers for
/// small matrices, exist for others as well.
PetscErrorCode ask_cholmod(Mat factor, Inertia *inertia) {
  PetscOptions database = nullptr;
  const char *prefix = nullptr;
  std::array<char, 32> kind{};
  PetscFunctionBegin;
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(factor), &database));
  PetscCall(MatGetOptionsPrefix(factor, &prefix));
  PetscCall(PetscOptionsGetString(database, prefix, "-mat_cholmod_factor", kind.data(), kind.size(),
                                  nullptr));
  if (std::string(kind.data()) == "SUPERNODAL") *inertia = Inertia::definite;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// MUMPS counts negative pivots unless it was told that the matrix is positive definite. Those of a
/// root that several ranks share are left out, unless ICNTL(13) keeps it on one.
PetscErrorCode ask_mumps(KSP ksp, Mat factor, Inertia *inertia) {
  PetscFunctionBegin;
#if defined(PETSC_HAVE_MUMPS)
  Mat matrix = nullptr;
  PetscBool known = PETSC_FALSE, definite = PETSC_FALSE;
  PetscInt error = 0, negative = 0, whole_root = 0;
  PetscMPIInt ranks = 0;
  PetscCall(KSPGetOperators(ksp, nullptr, &matrix));
  PetscCall(MatIsSPDKnown(matrix, &known, &definite));
  if (known && definite) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatMumpsGetInfog(factor, 1, &error));
  PetscCall(MatMumpsGetInfog(factor, 12, &negative));
  PetscCall(MatMumpsGetIcntl(factor, 13, &whole_root));
  PetscCallMPI(MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(factor)), &ranks));
  const bool singular = error == -10;
  if (singular || negative > 0) {
    *inertia = Inertia::indefinite;
  } else if (error >= 0 && (ranks == 1 || whole_root == 1)) {
    *inertia = Inertia::definite;
  }
#else
  static_cast<void>(ksp), static_cast<void>(factor), static_cast<void>(inertia);
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// PETSc's Cholesky factors count them, for matrices of block size 1.
PetscErrorCode count_by_cholesky(Mat factor, Inertia *inertia) {
  PetscInt negative = 0, zero = 0, positive = 0;
  PetscFunctionBegin;
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  const PetscErrorCode error = MatGetInertia(factor, &negative, &zero, &positive);
  PetscCall(PetscPopErrorHandler());
  if (error == PETSC_ERR_SUP) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(error);
  *inertia = negative + zero == 0 ? Inertia::definite : Inertia::indefinite;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// PETSc's LU exchanges no rows: of a symmetric matrix U's diagonal is the D of L D L', also where
/// rows of Dirichlet conditions alone are not symmetric.
PetscErrorCode count_by_lu(Mat factor, Inertia *inertia) {
  PetscBool rows = PETSC_FALSE;
  PetscReal least = 0;
  Vec pivots = nullptr;
  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(factor), MATSEQAIJ, &rows));
  if (!rows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(MatCreateVecs(factor, &pivots, nullptr));
  PetscCall(MatGetDiagonal(factor, pivots));
  PetscCall(VecMin(pivots, nullptr, &least));
  PetscCall(VecDestroy(&pivots));
  *inertia = least > 0 ? Inertia::definite : Inertia::indefinite;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// PETSc's own factors, unless they shift the diagonal.
PetscErrorCode ask_petsc(PC pc, Mat factor, Inertia *inertia) {
  PCFailedReason failed = PC_NOERROR;
  MatFactorShiftType shift = MAT_SHIFT_NONE;
  PetscBool cholesky = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(PCFactorGetShiftType(pc, &shift));
  if (shift != MAT_SHIFT_NONE) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCGetFailedReason(pc, &failed));
  if (failed) {  // a zero pivot
    *inertia = Inertia::indefinite;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
  if (cholesky) {
    PetscCall(count_by_cholesky(factor, inertia));
  } else {
    PetscCall(count_by_lu(factor, inertia));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether pivots have the signs of the matrix's eigenvalues: of other packages' LU, which exchange
/// rows, they do not.
PetscErrorCode have_signed_pivots(PC pc, bool *have) {
  PetscBool cholesky = PETSC_FALSE, lu = PETSC_FALSE;
  MatSolverType package = nullptr;
  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCLU, &lu));
  if (lu) PetscCall(PCFactorGetMatSolverType(pc, &package));
  *have = cholesky || (package && package == std::string(MATSOLVERPETSC));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

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

PetscErrorCode makes_signed_factors(KSP ksp, bool *makes) {
  PC pc = nullptr;
  PetscBool lagged = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(have_signed_pivots(pc, makes));
  PetscCall(KSPGetReusePreconditioner(ksp, &lagged));
  *makes = *makes && !lagged;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode inertia_of_factors(KSP ksp, Inertia *inertia) {
  PC pc = nullptr;
  Mat factor = nullptr;
  MatSolverType solver = nullptr;
  bool signed_pivots = false;
  PetscFunctionBegin;
  *inertia = Inertia::unknown;
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(have_signed_pivots(pc, &signed_pivots));
  if (!signed_pivots) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatFactorGetSolverType(factor, &solver));
  const std::string package = solver ? solver : "";
  if (package == MATSOLVERCHOLMOD) {
    PetscCall(ask_cholmod(factor, inertia));
  } else if (package == MATSOLVERMUMPS) {
    PetscCall(ask_mumps(ksp, factor, inertia));
  } else if (package == MATSOLVERPETSC) {
    PetscCall(ask_petsc(pc, factor, inertia));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
