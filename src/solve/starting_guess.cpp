#include "solve/starting_guess.hpp"

#include <petscksp.h>
#include <petsctime.h>

#include <array>

#include "solve/cholesky.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Laplace's matrix for each displacement component: the same one for all three where every vertex
/// is wholly free or wholly held.
class ComponentSolver {
 public:
  ComponentSolver(bool iterative, PetscReal tolerance)
      : iterative_(iterative), tolerance_(tolerance) {}
  ~ComponentSolver() {
    for (std::size_t i = 0; i < 3; ++i) {  // errors have nowhere to go from here
      static_cast<void>(ISDestroy(&unknowns_[i]));
      static_cast<void>(KSPDestroy(&solver_[i]));
      static_cast<void>(VecDestroy(&right_[i]));
      static_cast<void>(VecDestroy(&change_[i]));
    }
  }

  /// @param H sum over the elements of the matrices of all components, which do not mix
  PetscErrorCode set_up(const Discretization &discretization, Mat H);
  /// x -= K^-1 g, component by component.
  PetscErrorCode correct(Vec g, Vec x, GuessCost *cost);

 private:
  PetscErrorCode find_unknowns(const Discretization &discretization, Mat H);

  bool iterative_;
  PetscReal tolerance_;
  std::size_t components_ = 3;
  std::array<IS, 3> unknowns_{};
  std::array<KSP, 3> solver_{};
  std::array<Vec, 3> right_{}, change_{};
};

/// This rank's unknowns by component.
PetscErrorCode ComponentSolver::find_unknowns(const Discretization &discretization, Mat H) {
  PetscInt begin = 0, end = 0;
  std::array<std::vector<PetscInt>, 3> unknowns;
  PetscFunctionBeginUser;
  PetscCall(MatGetOwnershipRange(H, &begin, &end));
  std::vector<int> component(static_cast<std::size_t>(end - begin), 0);
  const auto &dofs = discretization.global_dofs();
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (dofs[k] < begin || dofs[k] >= end) continue;
    component[static_cast<std::size_t>(dofs[k] - begin)] = static_cast<int>(k % 3);
  }
  for (PetscInt row = begin; row < end; ++row) {
    unknowns[static_cast<std::size_t>(component[static_cast<std::size_t>(row - begin)])].push_back(
        row);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    PetscCall(ISCreateGeneral(PetscObjectComm(reinterpret_cast<PetscObject>(H)),
                              static_cast<PetscInt>(unknowns[i].size()), unknowns[i].data(),
                              PETSC_COPY_VALUES, &unknowns_[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// MUMPS's own guess of its memory, 20 % more than the analysis says, is sometimes short.
/// -guess_mat_mumps_icntl_14, read later, has the last word.
PetscErrorCode give_mumps_memory(PC pc) {
  PetscFunctionBeginUser;
#if defined(PETSC_HAVE_MUMPS)
  PetscBool cholesky = PETSC_FALSE, mumps = PETSC_FALSE;
  MatSolverType solver = nullptr;
  Mat factor = nullptr;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCCHOLESKY, &cholesky));
  if (!cholesky) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorGetMatSolverType(pc, &solver));
  PetscCall(PetscStrcmp(solver, MATSOLVERMUMPS, &mumps));
  if (!mumps) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PCFactorSetUpMatSolverType(pc));
  PetscCall(PCFactorGetMatrix(pc, &factor));
  PetscCall(MatMumpsSetIcntl(factor, 14, 100));
#else
  static_cast<void>(pc);
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ComponentSolver::set_up(const Discretization &discretization, Mat H) {
  PetscFunctionBeginUser;
  PetscCall(find_unknowns(discretization, H));
  const bool same = discretization.has_whole_blocks();
  components_ = static_cast<std::size_t>(discretization.mesh().dimension());
  for (std::size_t i = 0; i < components_; ++i) {
    if (i > 0 && same) {
      PetscCall(PetscObjectReference(reinterpret_cast<PetscObject>(solver_[0])));
      solver_[i] = solver_[0];
    } else {
      Mat laplace = nullptr;
      PetscCall(MatCreateSubMatrix(H, unknowns_[i], unknowns_[i], MAT_INITIAL_MATRIX, &laplace));
      PetscCall(MatSetOption(laplace, MAT_SPD, PETSC_TRUE));
      PetscCall(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(H)), &solver_[i]));
      PetscCall(KSPSetOperators(solver_[i], laplace, laplace));
      PetscCall(set_guess_solver(solver_[i], iterative_, tolerance_));
      PetscCall(MatDestroy(&laplace));
    }
    Mat laplace = nullptr;
    PetscCall(KSPGetOperators(solver_[i], &laplace, nullptr));
    PetscCall(MatCreateVecs(laplace, &change_[i], &right_[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ComponentSolver::correct(Vec g, Vec x, GuessCost *cost) {
  PetscFunctionBeginUser;
  for (std::size_t i = 0; i < components_; ++i) {
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    PetscInt iterations = 0;
    PetscCall(VecISCopy(g, unknowns_[i], SCATTER_REVERSE, right_[i]));
    PetscCall(KSPSolve(solver_[i], right_[i], change_[i]));
    PetscCall(KSPGetConvergedReason(solver_[i], &reason));
    PetscCheck(reason > 0, PetscObjectComm(reinterpret_cast<PetscObject>(x)), PETSC_ERR_CONV_FAILED,
               "the linear solver of the starting guess failed (%s); use -initial rest, or tune it "
               "by -guess_ksp_* and -guess_pc_*",
               KSPConvergedReasons[reason]);
    PetscCall(KSPGetIterationNumber(solver_[i], &iterations));
    ++cost->linear_solves;
    cost->linear_iterations += iterations;
    PetscCall(VecISAXPY(x, unknowns_[i], -1, change_[i]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode set_guess_solver(KSP ksp, bool iterative, PetscReal tolerance) {
  PC pc = nullptr;
  PetscFunctionBeginUser;
  PetscCall(KSPGetPC(ksp, &pc));
  if (iterative) {
    PetscCall(KSPSetType(ksp, KSPCG));
    PetscCall(KSPSetTolerances(ksp, tolerance, PETSC_DEFAULT, PETSC_DEFAULT, 500));
    PetscCall(PCSetType(pc, PCGAMG));
  } else {
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(set_cholesky(pc));
  }
  PetscCall(KSPSetOptionsPrefix(ksp, "guess_"));
  PetscCall(KSPSetFromOptions(ksp));
  PetscCall(give_mumps_memory(pc));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode spread_displacements(const EnergyFunctional &functional,
                                    const Discretization &discretization, Mat H,
                                    PetscInt rotation_steps, bool iterative, Progress &progress,
                                    Vec x, GuessCost *cost) {
  // What a solve leaves over is in the gradient of the next step: of twenty to a tenth, with two
  // iterations each, the guess is as good as of twenty to 1e-4.
  const PetscReal tolerance = rotation_steps > 0 ? 0.1 : guess_tolerance;
  PetscLogDouble begin = 0, end = 0;
  PetscReal size = 0;
  Vec g = nullptr;
  TrefoilSplitStatistics ignored{};
  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin));
  PetscCall(VecDuplicate(x, &g));
  const auto harmonic = functional.spreading(Spreading::harmonic);
  PetscCall(harmonic->gradient(x, g));
  PetscCall(VecNorm(g, NORM_INFINITY, &size));
  if (size > 0) {
    ComponentSolver solver(iterative, tolerance);
    PetscCall(harmonic->hessian(x, H, nullptr, &ignored));
    PetscCall(solver.set_up(discretization, H));
    PetscCall(solver.correct(g, x, cost));
    const auto rigid = functional.spreading(Spreading::rigid);
    for (PetscInt step = 0; step < rotation_steps; ++step) {
      PetscCall(progress.pass("start: local/global step " + std::to_string(step + 1) + " of " +
                              std::to_string(rotation_steps)));
      PetscCall(rigid->gradient(x, g));
      PetscCall(solver.correct(g, x, cost));
    }
    cost->rotations = rotation_steps;
  }
  PetscCall(VecDestroy(&g));
  PetscCall(PetscTime(&end));
  cost->seconds += end - begin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
