#include "search/newton_direction.hpp"

#include <petscksp.h>

#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

/// How many steps pay: many from factors, none from an iterative solver, of which each is one more
/// linear system.
PetscErrorCode most_steps(const SearchOptions &options, const Rule &rule, KSP ksp, int *most) {
  constexpr int from_factors = 8;
  PetscBool direct = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &direct));
  *most = options.newton_steps;
  if (*most < 0) *most = direct && rule.prefers_newton() ? from_factors : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The vectors of conjugate gradients; p is a direction of theirs, d their sum.
struct ConjugateGradients {
  Vec r = nullptr, z = nullptr, p = nullptr, Hp = nullptr, d = nullptr;

  PetscErrorCode begin(LineSearchState &state) {
    PetscFunctionBeginUser;
    PetscCall(state.work.get(Work::cg_residual, state.x, &r));
    PetscCall(state.work.get(Work::cg_preconditioned, state.x, &z));
    PetscCall(state.work.get(Work::cg_direction, state.x, &p));
    PetscCall(state.work.get(Work::product, state.x, &Hp));
    PetscCall(state.work.get(Work::newton_direction, state.x, &d));
    PetscCall(VecAXPBY(r, -1, 0, state.residual));
    PetscCall(VecCopy(state.d, p));
    PetscCall(VecSet(d, 0));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};

/// z of r, by the linear solver of the filtered Jacobian; r'z is zero where it found none.
PetscErrorCode precondition(KSP ksp, const ConjugateGradients &cg, SolveRecord &record,
                            double *rz) {
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  PetscFunctionBeginUser;
  PetscCall(VecSet(cg.z, 0));  // where a solver begins that starts from a guess
  PetscCall(KSPSolve(ksp, cg.r, cg.z));
  PetscCall(KSPGetConvergedReason(ksp, &reason));
  PetscCall(KSPGetIterationNumber(ksp, &iterations));
  ++record.linear_solves;
  record.krylov_iterations += static_cast<int>(iterations);
  PetscCall(dot(cg.r, cg.z, rz));
  if (reason < 0) *rz = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode turn_to_newton(const SearchOptions &options, const Rule &rule, SNES snes,
                              const FilteredJacobian &jacobian, LineSearchState &state,
                              SolveRecord &record) {
  // Newton's quadratic convergence is that of w = 0; a tenth is as good while the filter is needed.
  constexpr double enough = 0.1, curvature_noise = 1e-10;
  ConjugateGradients cg;
  KSP ksp = nullptr;
  int most = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(most_steps(options, rule, ksp, &most));
  if (most == 0 || jacobian.is_unfiltered() || jacobian.weight() > 0.5 || state.lifted ||
      !(state.slope < 0)) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Phase phase = record.clock.switch_to(Phase::linear_solve);
  PetscCall(cg.begin(state));
  double rz = -state.slope, slope = 0;
  double squared_norm = rz;  // of p in the solver's norm; the terms are orthogonal in it
  const double least = enough * enough * rz;
  for (int k = 0;; ++k) {
    double curvature = 0;
    PetscCall(jacobian.unfiltered_curvature(cg.p, cg.Hp, &curvature));
    if (!(curvature > curvature_noise * squared_norm)) break;
    PetscCall(VecAXPY(cg.d, rz / curvature, cg.p));
    PetscCall(VecAXPY(cg.r, -rz / curvature, cg.Hp));
    if (k == most) break;
    const double last = rz;
    PetscCall(precondition(ksp, cg, record, &rz));
    ++record.current.newton_steps;
    if (!(rz > least)) break;
    squared_norm = rz + (rz / last) * (rz / last) * squared_norm;
    PetscCall(VecAYPX(cg.p, rz / last, cg.z));
  }
  PetscCall(dot(state.residual, cg.d, &slope));
  if (slope < 0) state.aim(cg.d, slope);  // zero where already the first curvature is negative
  record.clock.switch_to(phase);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
