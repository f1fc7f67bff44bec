#include <petscksp.h>

#include <array>
#include <cmath>

#include "search/line.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode ask_factor(SNES snes, FactorSays *says) {
  KSP ksp = nullptr;
  PC pc = nullptr;
  Mat factor = nullptr;
  MatSolverType solver = nullptr;
  PetscBool cholesky = PETSC_FALSE, mumps = PETSC_FALSE, cholmod = PETSC_FALSE;
  PetscFunctionBegin;
  *says = FactorSays::nothing;
  PetscCall(SNESGetKSP(snes, &ksp));
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
    if (std::string(kind.data()) == "SUPERNODAL") *says = FactorSays::definite;
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
    *says = error >= 0 && negative == 0 ? FactorSays::definite : FactorSays::indefinite;
  }
#endif
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace {

enum class Verdict { good, not_finite, indefinite, ascends };

/// Newton's plain direction from an indefinite Hessian may descend by luck; it is none to follow.
PetscErrorCode judge(SolveContext &context, const Line &line, Verdict *verdict) {
  const bool unfiltered = context.current.weight < 0.5;
  KSPConvergedReason solved = KSP_CONVERGED_ITERATING;
  FactorSays says = FactorSays::nothing;
  KSP ksp = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(KSPGetConvergedReason(ksp, &solved));
  *verdict = Verdict::good;
  if (unfiltered && solved < 0) {
    *verdict = Verdict::indefinite;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!std::isfinite(line.slope) || !std::isfinite(context.current.energy)) {
    *verdict = Verdict::not_finite;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (unfiltered) PetscCall(ask_factor(context.snes, &says));
  if (says == FactorSays::indefinite || (line.slope > 0 && !line.lifted)) {
    *verdict = unfiltered ? Verdict::indefinite : Verdict::ascends;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The Jacobian at x once more, and the solver's preconditioner, also where the SNES lags them.
PetscErrorCode compute_jacobian_now(SNES snes, Vec x) {
  Mat J = nullptr, H = nullptr;
  KSP ksp = nullptr;
  PetscInt jacobian_lag = 1, preconditioner_lag = 1;
  PetscFunctionBegin;
  PetscCall(SNESGetLagJacobian(snes, &jacobian_lag));
  PetscCall(SNESGetLagPreconditioner(snes, &preconditioner_lag));
  PetscCall(SNESSetLagJacobian(snes, 1));
  PetscCall(SNESSetLagPreconditioner(snes, 1));
  PetscCall(SNESGetJacobian(snes, &J, &H, nullptr, nullptr));
  PetscCall(SNESComputeJacobian(snes, x, J, H));
  PetscCall(SNESSetLagJacobian(snes, jacobian_lag));
  PetscCall(SNESSetLagPreconditioner(snes, preconditioner_lag));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetOperators(ksp, J, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The direction once more, from a Jacobian with another weight.
PetscErrorCode replace_direction(SolveContext &context, Line &line, double weight) {
  KSP ksp = nullptr;
  PetscScalar slope = 0;
  PetscInt linear_iterations = 0;
  PetscFunctionBegin;
  context.instead_of_rejected = weight;
  PetscCall(compute_jacobian_now(context.snes, line.solution));
  context.instead_of_rejected.reset();
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(KSPSolve(ksp, line.residual, line.minus_d));
  PetscCall(KSPGetIterationNumber(ksp, &linear_iterations));
  PetscCall(VecDot(line.residual, line.minus_d, &slope));
  context.clock.switch_to(Phase::line_search);
  line.slope = -PetscRealPart(slope);
  context.current.decrement = std::abs(line.slope) / 2;
  context.current.linear_iterations = static_cast<int>(linear_iterations);
  context.current.linear_solves = context.summary.linear_solves;
  context.current.seconds = context.head_start + context.clock.elapsed();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode judge_direction(SolveContext &context, Line &line, SNESConvergedReason *reason) {
  Verdict verdict = Verdict::good;
  PetscFunctionBegin;
  *reason = SNES_CONVERGED_ITERATING;
  PetscCall(judge(context, line, &verdict));
  while (verdict == Verdict::indefinite && !line.lifted) {
    const std::optional<double> weight = context.rule->rejected(context.current);
    if (!weight) break;
    PetscCall(replace_direction(context, line, *weight));
    PetscCall(judge(context, line, &verdict));
  }
  switch (verdict) {
    case Verdict::good:
      break;
    case Verdict::not_finite:
      context.summary.reason = "the energy or the direction is not finite";
      *reason = SNES_DIVERGED_FNORM_NAN;
      break;
    case Verdict::indefinite:
      context.summary.reason =
          "the Hessian is indefinite and the filter leaves it so; filter adaptive, absolute or "
          "clamp do not";
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
    case Verdict::ascends:
      context.summary.reason =
          "the direction ascends: the linear solve is too inexact or the residual is no gradient "
          "of the objective";
      *reason = SNES_DIVERGED_LINEAR_SOLVE;
      break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
