#include <petscksp.h>

#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

static PetscErrorCode after_linear_solve(KSP ksp, Vec, Vec, void *ctx) {
  auto &record = *static_cast<SolveRecord *>(ctx);
  PetscInt iterations = 0;
  PetscBool reused = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(KSPGetReusePreconditioner(ksp, &reused));
  record.factorisations += !reused;
  PetscCall(KSPGetIterationNumber(ksp, &iterations));
  record.current.linear_iterations = static_cast<int>(iterations);
  record.clock.switch_to(Phase::other);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode record_foreign_iteration(Solver &solver, Vec x) {
  SolveRecord &record = solver.record;
  IterationRecord &current = record.current;
  KSP ksp = nullptr;
  Vec residual = nullptr;
  const double seconds = record.seconds();
  PetscFunctionBeginUser;
  if (current.k > 0) {
    SNESLineSearch search = nullptr;
    PetscReal step = 0;
    PetscCall(SNESGetLineSearch(solver.snes, &search));
    PetscCall(SNESLineSearchGetLambda(search, &step));
    IterationRecord last = record.history.back();
    record.history.pop_back();
    last.linear_iterations = current.linear_iterations;
    last.step = step;
    PetscCall(solver.close_iteration(last));
  }
  PetscCall(solver.energy.at(x, &current.energy));
  PetscCall(SNESGetFunction(solver.snes, &residual, nullptr, nullptr));
  PetscCall(VecNorm(residual, NORM_2, &current.gradient_norm));
  current.linear_solves = record.linear_solves + 1;  // with the one to come
  current.seconds = seconds;
  current.indefinite = IterationRecord::none;
  record.history.push_back(current);
  PetscCall(SNESGetKSP(solver.snes, &ksp));
  PetscCall(KSPSetPostSolve(ksp, after_linear_solve, &record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
