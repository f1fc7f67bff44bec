#include "solve/multigrid.hpp"

#include <petscksp.h>

#include <string>

#include "assembly/corner_interpolation.hpp"
#include "solve/cholesky.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Hides the options of a level's solver from it. @return their prefix
PetscErrorCode hide_options(KSP level, std::string *prefix) {
  const char *text = nullptr;
  PetscFunctionBeginUser;
  PetscCall(KSPGetOptionsPrefix(level, &text));
  *prefix = text;
  PetscCall(KSPSetOptionsPrefix(level, "trefoil_hidden_"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_types(KSP level, KSPType krylov, PCType preconditioner) {
  PC pc = nullptr;
  PetscFunctionBeginUser;
  PetscCall(KSPSetType(level, krylov));
  PetscCall(KSPGetPC(level, &pc));
  PetscCall(PCSetType(pc, preconditioner));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Lets PCMG make the coarse matrix, which it keeps: its rigid-body modes have to be there before
/// anything is made of it. Smoothers and coarse solver have to wait, with their options: there are
/// no numbers yet.
PetscErrorCode make_coarse_matrix(PC pc, KSP smoother, KSP coarse) {
  std::string smoothers, coarses;
  PetscFunctionBeginUser;
  PetscCall(hide_options(smoother, &smoothers));
  PetscCall(hide_options(coarse, &coarses));
  PetscCall(set_types(smoother, KSPRICHARDSON, PCNONE));
  PetscCall(set_types(coarse, KSPPREONLY, PCNONE));
  PetscCall(PCSetUp(pc));
  PetscCall(KSPSetOptionsPrefix(smoother, smoothers.c_str()));
  PetscCall(KSPSetOptionsPrefix(coarse, coarses.c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// One step of Chebyshev's each way, from SSOR: twice as many cost more than they save.
PetscErrorCode set_smoother(KSP smoother) {
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(smoother)), &ranks));
  PetscCall(set_types(smoother, KSPCHEBYSHEV, PCSOR));
  PetscCall(KSPSetTolerances(smoother, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT, 1));
  // SSOR of a positive definite matrix, D its diagonal and L what is below, is larger than it by
  // L D^-1 L', so no eigenvalue is above 1. Across ranks that is lost, and PETSc estimates them.
  if (ranks == 1) PetscCall(KSPChebyshevSetEigenvalues(smoother, 1.05, 0.1));
  PetscCall(KSPSetFromOptions(smoother));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_coarse_solver(KSP coarse, Mat matrix) {
  constexpr PetscInt most_to_factor = 40000;  // unknowns
  PetscInt size = 0;
  PC pc = nullptr;
  PetscFunctionBeginUser;
  PetscCall(MatGetSize(matrix, &size, nullptr));
  PetscCall(KSPGetPC(coarse, &pc));
  if (size > most_to_factor) {
    PetscCall(set_aggregation(pc));
  } else {
    PetscCall(set_cholesky(pc));
  }
  PetscCall(KSPSetFromOptions(coarse));
  PetscCall(set_large_aggregates(pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode set_aggregation(PC pc) {
  PetscReal threshold = 0.02;
  PetscFunctionBeginUser;
  PetscCall(PCSetType(pc, PCGAMG));
  PetscCall(PCGAMGSetThreshold(pc, &threshold, 1));
  PetscCall(PCGAMGSetReuseInterpolation(pc, PETSC_TRUE));
  PetscCall(PCGAMGSetUseSAEstEig(pc, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_large_aggregates(PC pc) {
  constexpr PetscInt levels = 2;
  const char *prefix = nullptr;
  PetscBool is_given = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PCGetOptionsPrefix(pc, &prefix));
  for (const char *option : {"-pc_gamg_aggressive_coarsening", "-pc_gamg_square_graph"}) {
    PetscCall(PetscOptionsHasName(nullptr, prefix, option, &is_given));
    if (is_given) PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(PCGAMGSetAggressiveLevels(pc, levels));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_p_multigrid(const Discretization &discretization, Mat H, PC pc) {
  CornerInterpolation interpolation;
  KSP smoother = nullptr, coarse = nullptr;
  Mat matrix = nullptr;
  PetscFunctionBeginUser;
  PetscCall(interpolation.set_up(discretization));
  PetscCall(PCSetType(pc, PCMG));
  PetscCall(PCMGSetLevels(pc, 2, nullptr));
  PetscCall(PCMGSetGalerkin(pc, PC_MG_GALERKIN_BOTH));
  PetscCall(PCMGSetInterpolation(pc, 1, interpolation.matrix()));
  PetscCall(PCSetOperators(pc, H, H));
  PetscCall(PCMGGetSmoother(pc, 1, &smoother));
  PetscCall(PCMGGetCoarseSolve(pc, &coarse));
  PetscCall(make_coarse_matrix(pc, smoother, coarse));
  PetscCall(KSPGetOperators(coarse, nullptr, &matrix));
  PetscCall(interpolation.attach_modes(H, matrix));
  PetscCall(set_smoother(smoother));
  PetscCall(set_coarse_solver(coarse, matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
