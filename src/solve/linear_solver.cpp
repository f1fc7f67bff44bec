#include "solve/linear_solver.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode get_types(SNES snes, KSP *ksp, PC *pc, std::string *krylov, std::string *kind) {
  KSPType krylov_type = nullptr;
  PCType pc_type = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(snes, ksp));
  PetscCall(KSPGetPC(*ksp, pc));
  PetscCall(KSPGetType(*ksp, &krylov_type));
  PetscCall(PCGetType(*pc, &pc_type));
  *krylov = krylov_type ? krylov_type : "";
  *kind = pc_type ? pc_type : "";
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What a preconditioner is called; of p-multigrid also what solves for the linear elements.
PetscErrorCode name_of(PC pc, const std::string &kind, std::string *name) {
  PetscInt levels = 0;
  PetscFunctionBeginUser;
  *name = kind == PCCHOLESKY ? "Cholesky" : kind == PCLU ? "LU" : kind;
  if (kind == PCMG) PetscCall(PCMGGetLevels(pc, &levels));
  if (levels == 2) {
    KSP coarse = nullptr;
    PC below = nullptr;
    PCType type = nullptr;
    PetscCall(PCMGGetCoarseSolve(pc, &coarse));
    PetscCall(KSPGetPC(coarse, &below));
    PetscCall(PCGetType(below, &type));
    *name = std::string("p-multigrid over ") + type;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Bytes of the factor after its analysis; 0 where the package does not tell.
PetscErrorCode bytes_of_factor([[maybe_unused]] Mat factor,
                               [[maybe_unused]] const std::string &package, double *bytes) {
  PetscFunctionBeginUser;
  *bytes = 0;
#if defined(PETSC_HAVE_SUITESPARSE)
  if (package == MATSOLVERCHOLMOD) {
    MatInfo info;
    PetscCall(MatGetInfo(factor, MAT_GLOBAL_SUM, &info));
    *bytes = info.nz_allocated * static_cast<double>(sizeof(PetscScalar));
  }
#endif
#if defined(PETSC_HAVE_MUMPS)
  if (package == MATSOLVERMUMPS) {  // INFOG(17): megabytes that it will allocate, all ranks
    PetscInt megabytes = 0;
    PetscCall(MatMumpsGetInfog(factor, 17, &megabytes));
    *bytes = 1e6 * static_cast<double>(megabytes);
  }
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lets the package of a direct solver look at the pattern.
PetscErrorCode analyse(Mat matrix, const std::string &package, MatFactorType type, double *bytes) {
  Mat factor = nullptr;
  IS rows = nullptr, columns = nullptr;
  MatFactorInfo info;
  PetscFunctionBeginUser;
  PetscCall(MatGetFactor(matrix, package.c_str(), type, &factor));
  PetscCall(MatGetOrdering(matrix, MATORDERINGEXTERNAL, &rows, &columns));
  PetscCall(MatFactorInfoInitialize(&info));
  if (type == MAT_FACTOR_CHOLESKY) {
    PetscCall(MatCholeskyFactorSymbolic(factor, matrix, rows, &info));
  } else {
    PetscCall(MatLUFactorSymbolic(factor, matrix, rows, columns, &info));
  }
  PetscCall(bytes_of_factor(factor, package, bytes));
  PetscCall(ISDestroy(&rows));
  PetscCall(ISDestroy(&columns));
  PetscCall(MatDestroy(&factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode describe_linear_solver(SNES snes, LinearSolver *solver) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  std::string krylov, kind, method;
  PetscFunctionBeginUser;
  PetscCall(get_types(snes, &ksp, &pc, &krylov, &kind));
  const bool direct = krylov == KSPPREONLY;
  PetscCall(name_of(pc, kind, &method));
  solver->text = direct ? method : krylov + " with " + method;
  if (kind == PCCHOLESKY || kind == PCLU) {
    MatSolverType package = nullptr;
    PetscCall(PCFactorGetMatSolverType(pc, &package));
    if (package) solver->text += std::string(" by ") + package;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode expect_linear_solver(SNES snes, Mat matrix, LinearSolver *solver) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  std::string krylov, kind;
  MatSolverType package = nullptr;
  PetscFunctionBeginUser;
  PetscCall(describe_linear_solver(snes, solver));
  PetscCall(get_types(snes, &ksp, &pc, &krylov, &kind));
  if (kind != PCCHOLESKY && kind != PCLU) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatSolverType(pc, &package));
  if (!package) PetscFunctionReturn(PETSC_SUCCESS);
  const bool knows_size =
      std::string(package) == MATSOLVERCHOLMOD || std::string(package) == MATSOLVERMUMPS;
  if (!knows_size) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(analyse(matrix, package, kind == PCCHOLESKY ? MAT_FACTOR_CHOLESKY : MAT_FACTOR_LU,
                    &solver->factor_bytes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
