/*
   An iteration of the line search `trefoil`. It is called with the direction d = -Y that the
   filtered Jacobian gave, decides whether the solve ends here, and otherwise takes a step along d:

     stop test on the Newton decrement |g'd| / 2, or the largest entry of d, before the step is
     taken
     s = 1, 0.8, 0.64, ...  until  f(x + s d) <= f(x) + c s g'd           (Armijo)
     rho = (f(x) - f(x + u)) / -(g'u + u'Hu/2),   u = s d                 (trust-region ratio)

   with u'Hu = u'(H + 2 w N) u - 2 w u'N u: the unfiltered model costs two products, no assembly.

   The direction of a filtered Jacobian may first be turned into Newton's, by conjugate gradients
   with the same factors (-snes_trefoil_newton_steps).

   With -snes_trefoil_search subspace the search begins at the energy's minimum in the plane of d
   and the previous step, and is followed by Shamanskii steps, from the factors of the same
   Jacobian.
*/
#include "snes/iteration.hpp"

#include <petsc/private/snesimpl.h>
#include <petscksp.h>

#include <string>

#include "search/direction.hpp"
#include "search/energy_check.hpp"
#include "search/inexact.hpp"
#include "search/newton_direction.hpp"
#include "search/shamanskii.hpp"
#include "search/step.hpp"
#include "search/stop_test.hpp"
#include "search/subspace_minimisation.hpp"
#include "search/verify_minimum.hpp"
#include "snes/line.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Ends the solve with `reason`, x as it is, and closes the history.
PetscErrorCode finish(Solver &solver, SNESLineSearch search, SNESConvergedReason reason) {
  PetscFunctionBegin;
  solver.snes->reason = reason;
  PetscCall(SNESLineSearchSetReason(
      search, reason > 0 ? SNES_LINESEARCH_SUCCEEDED : SNES_LINESEARCH_FAILED_REDUCT));
  PetscCall(solver.close_iteration(solver.record.current));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Searches, takes the step found and those that follow from the same factors, and closes the
/// iteration with the step's trust-region ratio.
PetscErrorCode search_and_step(Solver &solver, SNESLineSearch search, LineSearchState &state) {
  const SearchOptions &options = solver.options.search;
  const bool in_plane = solver.memory.uses_planes(options) && !state.lifted;
  IterationRecord &current = solver.record.current;
  PetscInt most_trials = 0;
  PetscReal first_step = 0;
  Vec product = nullptr;
  double curvature = 0;
  bool accepted = false;

  PetscFunctionBegin;
  PetscCall(SNESLineSearchGetTolerances(search, nullptr, nullptr, nullptr, nullptr, nullptr,
                                        &most_trials));
  PetscCall(SNESLineSearchGetDamping(search, &first_step));
  if (solver.uses_hessian()) {
    PetscCall(
        turn_to_newton(options, *solver.rule, solver.snes, solver.jacobian, state, solver.record));
  }
  if (in_plane) PetscCall(minimise_in_plane(solver.jacobian, solver.memory, state));
  PetscCall(state.work.get(Work::product, state.x, &product));
  if (solver.uses_hessian()) {
    PetscCall(solver.jacobian.unfiltered_curvature(state.d, product, &curvature));
  }
  PetscCall(backtrack(options, state, first_step, most_trials, &accepted));
  current.trials = state.trials;
  current.truncated = state.truncated;
  if (!accepted) {
    PetscCall(refuse_foreign_objective(state));
    solver.record.reason = state.truncated && state.trials == 0
                               ? "no step along the direction is allowed"
                               : "no step along the direction decreases the energy";
    PetscCall(stay(state));
    PetscCall(finish(solver, search, SNES_DIVERGED_LINE_SEARCH));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  current.step = state.newton_share * state.step;
  if (!solver.uses_hessian()) {
    // Next time one length more is tried.
    solver.memory.proxy_scale *= state.step / options.shrink;
  } else if (!state.lifted) {
    PetscCall(trust_region_ratio(state, curvature, &current.rho));
  }
  PetscCall(take_step(search, state, solver.memory));
  if (in_plane) {
    PetscCall(take_shamanskii_steps(options, search, solver.jacobian, solver.memory, state,
                                    solver.record));
  }
  PetscCall(solver.close_iteration(current));
  solver.memory.learn(current, solver.options.rule.rho_tolerance);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Follows the direction that met the stop test, where that lowers the energy.
PetscErrorCode take_last_step(Solver &solver, SNESLineSearch search, LineSearchState &state) {
  constexpr PetscInt most_trials = 5;
  IterationRecord &current = solver.record.current;
  Vec product = nullptr;
  double curvature = 0;
  bool accepted = false;
  PetscFunctionBegin;
  PetscCall(state.work.get(Work::product, state.x, &product));
  if (solver.uses_hessian()) {
    PetscCall(solver.jacobian.unfiltered_curvature(state.d, product, &curvature));
  }
  PetscCall(backtrack(solver.options.search, state, 1, most_trials, &accepted));
  current.trials = state.trials;
  if (!accepted) {
    PetscCall(stay(state));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  current.step = state.step;
  current.truncated = state.truncated;
  if (solver.uses_hessian()) PetscCall(trust_region_ratio(state, curvature, &current.rho));
  PetscCall(take_step(search, state, solver.memory));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Ends the solve where the stop test is met, unless that point is a saddle that can be left.
PetscErrorCode finish_or_leave(Solver &solver, SNESLineSearch search, LineSearchState &state) {
  IterationRecord &current = solver.record.current;
  SNESConvergedReason reason = SNES_CONVERGED_SNORM_RELATIVE;
  PetscFunctionBegin;
  if (solver.uses_hessian()) {
    PetscCall(verify_minimum(solver.options.search, solver.options.stop, solver.snes,
                             solver.jacobian, state, solver.record, &reason));
  }
  if (reason > 0 && solver.options.stop.takes_last && state.slope < 0) {
    PetscCall(take_last_step(solver, search, state));
  }
  if (reason) {
    PetscCall(finish(solver, search, reason));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  current.step = state.step;
  current.trials = state.trials;
  current.truncated = state.truncated;
  PetscCall(take_step(search, state, solver.memory));
  PetscCall(solver.close_iteration(current));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A stop test that an inexact direction meets has to be met by a better one as well.
/// @param[out] refused why there is none
PetscErrorCode test_again(Solver &solver, KSP ksp, LineSearchState &state, bool is_newtons,
                          bool *stop, SNESConvergedReason *refused) {
  bool refined = false;
  PetscFunctionBegin;
  PetscCall(refine_direction(ksp, state, solver.record, &refined));
  if (!refined) PetscFunctionReturn(PETSC_SUCCESS);
  solver.record.reason.clear();
  PetscCall(check_direction(solver.snes, *solver.rule, solver.memory, solver.jacobian, state,
                            solver.record, refused));
  *stop = false;
  if (*refused) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(stop_test(solver.options.stop, solver.energy, state, is_newtons, solver.record, stop));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the solve ends here, before the direction is taken. Where options have kept the linear
/// solver from an exact one, the reason says so.
/// @param[out] refused why there is no direction
PetscErrorCode is_end(Solver &solver, LineSearchState &state, bool *stop,
                      SNESConvergedReason *refused) {
  const bool is_newtons =
      solver.uses_hessian() && (solver.jacobian.is_unfiltered() || solver.jacobian.weight() <= 0.5);
  KSP ksp = nullptr;
  PetscFunctionBegin;
  PetscCall(stop_test(solver.options.stop, solver.energy, state, is_newtons, solver.record, stop));
  if (!*stop || !solver.uses_hessian()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetKSP(solver.snes, &ksp));
  PetscCall(test_again(solver, ksp, state, is_newtons, stop, refused));
  if (*stop) PetscCall(measure_residual(ksp, state, solver.record));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode iterate(Solver &solver, SNESLineSearch search) {
  LineSearchState state(solver.energy, solver.memory.vectors, solver.record.clock);
  SNESConvergedReason refused = SNES_CONVERGED_ITERATING;
  bool stop = false;
  PetscFunctionBegin;
  PetscCall(open_line(solver, search, state));
  PetscCall(open_iteration(solver, state));
  if (!state.has_objective) {
    solver.record.reason = find_endless_descent(solver.record);
    if (!solver.record.reason.empty()) {
      PetscCall(solver.note(solver.record.reason));
      PetscCall(finish(solver, search, SNES_DIVERGED_LINE_SEARCH));
      PetscFunctionReturn(PETSC_SUCCESS);
    }
  }
  PetscCall(check_direction(solver.snes, *solver.rule, solver.memory, solver.jacobian, state,
                            solver.record, &refused));
  if (refused) {
    PetscCall(finish(solver, search, refused));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (!state.lifted) PetscCall(is_end(solver, state, &stop, &refused));
  if (refused) {
    PetscCall(finish(solver, search, refused));
  } else if (stop) {
    PetscCall(finish_or_leave(solver, search, state));
  } else {
    PetscCall(search_and_step(solver, search, state));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
