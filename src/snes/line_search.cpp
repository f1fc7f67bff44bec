/*
   The line search `trefoil`. It is called with the direction d = -Y that the filtered Jacobian
   gave, decides whether the solve ends here, and otherwise takes a step along d:

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
#include <petsc/private/linesearchimpl.h>
#include <petsc/private/snesimpl.h>

#include <cmath>

#include "search/boundary_values.hpp"
#include "search/direction.hpp"
#include "search/energy_check.hpp"
#include "search/inexact.hpp"
#include "search/newton_direction.hpp"
#include "search/shamanskii.hpp"
#include "search/step.hpp"
#include "search/stop_test.hpp"
#include "search/subspace_minimisation.hpp"
#include "search/verify_minimum.hpp"
#include "snes/solver.hpp"
#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

using namespace trefoil;

/// Refuses to drive what it does not know: types of SNES that use a line search in other ways.
static PetscErrorCode check_driven(const Solver &solver, SNESLineSearch search) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(search));
  PetscBool newton = PETSC_FALSE;
  SNESType type = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESGetType(solver.snes, &type));
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(solver.snes), &newton,
                                      SNESNEWTONLS, SNESTREFOIL, ""));
  PetscCheck(newton, comm, PETSC_ERR_SUP,
             "SNES type '%s' does not support line search trefoil, which is for types trefoil and "
             "newtonls: it needs Newton directions from a Jacobian, and knows no bounds",
             type);
  PetscCheck(solver.record.running && solver.driven, comm, PETSC_ERR_ORDER,
             "line search trefoil has not seen the Jacobian being made (were the SNES's monitors "
             "cancelled?): use -snes_type trefoil");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Refuses a search that compares energies where the host has given none.
static PetscErrorCode check_energies(const Solver &solver, bool has_objective) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes));
  PetscFunctionBegin;
  PetscCheck(has_objective || solver.options.search.kind != TREFOIL_SEARCH_SUBSPACE, comm,
             PETSC_ERR_ARG_WRONGSTATE,
             "-snes_trefoil_search subspace compares energies: set one with SNESSetObjective(), or "
             "use -snes_trefoil_search armijo");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the objective is an energy at all, at the first point that tells.
static PetscErrorCode examine_objective(Solver &solver, LineSearchState &state) {
  Vec product = nullptr;
  PetscReal norm = 0;
  double slope_of_half_square = 0;
  bool wanted = false, is_norm = false;
  PetscFunctionBegin;
  PetscCall(solver.energy.wants_examination(&wanted));
  if (!wanted || !solver.uses_hessian()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecNorm(state.residual, NORM_2, &norm));
  PetscCall(state.work.get(Work::product, state.solution, &product));
  PetscCall(solver.jacobian.multiply_unfiltered(state.d, product));
  PetscCall(dot(state.residual, product, &slope_of_half_square));
  PetscCall(solver.energy.examine_objective(state.energy, norm, state.slope, slope_of_half_square,
                                            &is_norm));
  if (!is_norm) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(
      solver.note("the objective is the norm of the residual, which is no energy: it is "
                  "ignored, and changes of the energy are integrated from the residual"));
  state.has_objective = false;
  state.energy = 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The SNES's vectors, and the linear solver's direction at x.
static PetscErrorCode open_line(Solver &solver, SNESLineSearch search, LineSearchState &state) {
  PetscBool changed = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(solver.energy.has_objective(&state.has_objective));
  PetscCall(check_driven(solver, search));
  PetscCall(SNESLineSearchGetVecs(search, &state.solution, &state.residual, &state.update,
                                  &state.trial, &state.trial_residual));
  PetscCall(SNESLineSearchPreCheck(search, state.solution, state.update, &changed));
  // Callbacks that copy their argument into a vector of theirs often have the solution for it: in
  // the manner of dolfinx's own SNES test. Trial points would then move the point they start from.
  PetscCall(state.work.get(Work::start, state.solution, &state.x));
  if (!solver.uses_hessian()) PetscCall(VecScale(state.update, solver.memory.proxy_scale));
  PetscCall(take_solvers_direction(state));
  state.clock.switch_to(Phase::line_search);  // ranks have waited for each other's solve
  PetscCall(solver.energy.at(state.solution, &state.energy));
  PetscCall(examine_objective(solver, state));
  PetscCall(check_energies(solver, state.has_objective));
  PetscCall(VecCopy(state.solution, state.x));
  if (solver.memory.boundary_values_open) {
    PetscCall(moves_boundary_values(solver.jacobian.matrix(), state, &solver.memory.held_rows,
                                    &state.lifted));
    solver.memory.boundary_values_open = state.lifted;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Opens the record of the iteration: what is known at x before anything is tried.
static PetscErrorCode open_iteration(Solver &solver, const LineSearchState &state) {
  SolveRecord &record = solver.record;
  IterationRecord opened;
  PetscInt iteration = 0, linear_iterations = 0;
  PetscBool reused = PETSC_FALSE;
  KSP ksp = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESGetKSP(solver.snes, &ksp));
  PetscCall(KSPGetReusePreconditioner(ksp, &reused));
  if (!solver.jacobian_is_new) {  // the SNES lags it
    ++record.iterations;
    ++record.linear_solves;
    record.current.refused = 0;
  }
  record.factorisations += solver.jacobian_is_new && !reused;
  solver.jacobian_is_new = false;
  PetscCall(SNESGetIterationNumber(solver.snes, &iteration));
  PetscCall(KSPGetIterationNumber(ksp, &linear_iterations));
  opened.k = static_cast<int>(iteration);
  opened.energy = state.energy;
  opened.weight = record.current.weight;
  opened.refused = record.current.refused;
  opened.indefinite = record.current.indefinite;
  opened.decrement = std::abs(state.slope) / 2;
  opened.linear_iterations = static_cast<int>(linear_iterations);
  record.krylov_iterations += static_cast<int>(linear_iterations);
  opened.linear_solves = record.linear_solves;
  opened.seconds = record.seconds();
  PetscCall(VecNorm(state.residual, NORM_2, &opened.gradient_norm));
  record.current = opened;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Ends the solve with `reason`, x as it is, and closes the history.
static PetscErrorCode finish(Solver &solver, SNESLineSearch search, SNESConvergedReason reason) {
  PetscFunctionBegin;
  solver.snes->reason = reason;
  PetscCall(SNESLineSearchSetReason(
      search, reason > 0 ? SNES_LINESEARCH_SUCCEEDED : SNES_LINESEARCH_FAILED_REDUCT));
  PetscCall(solver.close_iteration(solver.record.current));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Searches, takes the step found and those that follow from the same factors, and closes the
/// iteration with the step's trust-region ratio.
static PetscErrorCode search_and_step(Solver &solver, SNESLineSearch search,
                                      LineSearchState &state) {
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
static PetscErrorCode take_last_step(Solver &solver, SNESLineSearch search,
                                     LineSearchState &state) {
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
static PetscErrorCode finish_or_leave(Solver &solver, SNESLineSearch search,
                                      LineSearchState &state) {
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
static PetscErrorCode test_again(Solver &solver, LineSearchState &state, bool is_newtons,
                                 bool *stop) {
  KSP ksp = nullptr;
  bool refined = false;
  PetscFunctionBegin;
  PetscCall(SNESGetKSP(solver.snes, &ksp));
  if (solver.uses_hessian()) PetscCall(refine_direction(ksp, state, solver.record, &refined));
  if (!refined) PetscFunctionReturn(PETSC_SUCCESS);
  solver.record.reason.clear();
  PetscCall(stop_test(solver.options.stop, solver.energy, state, is_newtons, solver.record, stop));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// One iteration, from the direction on.
static PetscErrorCode iterate(Solver &solver, SNESLineSearch search) {
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
  if (!state.lifted) {
    const bool is_newtons = solver.uses_hessian() &&
                            (solver.jacobian.is_unfiltered() || solver.jacobian.weight() <= 0.5);
    PetscCall(
        stop_test(solver.options.stop, solver.energy, state, is_newtons, solver.record, &stop));
    if (stop) PetscCall(test_again(solver, state, is_newtons, &stop));
  }
  if (stop) {
    PetscCall(finish_or_leave(solver, search, state));
  } else {
    PetscCall(search_and_step(solver, search, state));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESLineSearchApply_Trefoil(SNESLineSearch search) {
  SNES snes = nullptr;
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(get_solver(snes, &solver));
  PetscCall(solver->begin_solve());
  PetscCall(PetscLogEventBegin(event_search, search, nullptr, nullptr, nullptr));
  PetscCall(iterate(*solver, search));
  PetscCall(PetscLogEventEnd(event_search, search, nullptr, nullptr, nullptr));
  solver->record.clock.switch_to(Phase::other);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SNES calls its monitors before each Jacobian: the place to see to it that ours is the one that
/// is called, whatever the host has set since.
static PetscErrorCode before_jacobian(SNES, PetscInt, PetscReal, void *solver) {
  PetscFunctionBegin;
  PetscCall(install_jacobian(*static_cast<Solver *>(solver)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESLineSearchSetFromOptions_Trefoil(SNESLineSearch search,
                                                           TrefoilOptionItems) {
  SNES snes = nullptr;
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(get_solver(snes, &solver));
  PetscCall(solver->set_from_options());
  PetscCall(SNESMonitorSet(snes, before_jacobian, solver, nullptr));  // once, PETSc compares
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESLineSearchView_Trefoil(SNESLineSearch search, PetscViewer viewer) {
  SNES snes = nullptr;
  Solver *solver = nullptr;
  PetscBool ascii = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(
      PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &ascii));
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(get_solver(snes, &solver));
  if (ascii) PetscCall(view_options(solver->options, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
   SNESLINESEARCHTREFOIL - backtracking on the energy along the eigenvalue-filtered direction

   Options Database Keys:
+  -snes_trefoil_filter <newton_first> - Filter of the element Hessians: newton, clamp, absolute,
     adaptive, constant, on_demand, blend, three_state, newton_first, multiplicative, tikhonov
.  -snes_trefoil_rho_tolerance <0.01> - adaptive: clamp while |rho - 1| is below this
     (dimensionless)
.  -snes_trefoil_weight <1> - constant: w of H + 2 w N; 0 Newton, 0.5 clamp, 1 absolute
.  -snes_trefoil_floor <-1> - Least eigenvalue of a filtered element, as a share of its largest;
     0 none; negative: the filter's own (tikhonov 1e-3, others none)
.  -snes_trefoil_space <element> - What is filtered: element, the element's Hessian;
     deformation, dP/dF at its quadrature points
.  -snes_trefoil_fields <> - Fields to filter, by name or number, separated by commas
.  -snes_trefoil_strict <true> - A Jacobian that cannot be filtered is an error; false: pass it
     unfiltered and count it in the record
.  -snes_trefoil_search <armijo> - Search: armijo, along the direction; subspace, in the plane
     of it and the previous step, with Shamanskii steps
.  -snes_trefoil_proxy <hessian> - Matrix P of the direction -P^-1 g: hessian, the filtered one;
     mass, as the host gives it; identity, gradient descent
.  -snes_trefoil_continue <false> - Filter and search go on from the end of the last solve of
     the same SNES
.  -snes_trefoil_corrections <-1> - subspace: most Shamanskii steps an iteration, by the same
     linear solver; -1: 8 where it is direct, else 0
.  -snes_trefoil_correction_gain <0.03> - subspace: least share of the first step's decrease to
     go on
.  -snes_trefoil_newton_steps <-1> - Most steps of conjugate gradients on the unfiltered Hessian
     that turn a filtered direction into Newton's, by the same linear solver; -1: 8 with filter
     newton_first where it is direct, else 0
.  -snes_trefoil_trust_start <false> - subspace: from the first iteration; false: once |rho - 1|
     is small
.  -snes_trefoil_decrement_tolerance <0> - Stop when the Newton decrement |g'd|/2 is below
     (energy units, 0 off)
.  -snes_trefoil_energy_tolerance <1e-08> - Stop when the decrement over the energy scale is
     below (dimensionless, 0 off; off where decrement_tolerance is set)
.  -snes_trefoil_direction_tolerance <0> - Stop when the direction is no larger, at filter
     weights up to 1/2: no entry of it, or no point's vector where the host says so (units of the
     unknowns, 0 off)
.  -snes_trefoil_take_last <false> - The direction that meets a stop test is followed before the
     solve ends
.  -snes_trefoil_verify_minimum <false> - Where the stop test is met, look for negative
     curvature of the unfiltered Hessian, and leave a saddle along it (off where
     decrement_tolerance is set)
.  -snes_trefoil_verify_share <0> - verify_minimum with an iterative solver: the most that it
     may take, as a share of the solve; 0: no bound
.  -snes_trefoil_monitor <false> - One line an iteration
.  -snes_trefoil_record <> - Write a JSON record of the solve to a file
.  -snes_linesearch_shrink <0.8> - Factor from a step length to the next
.  -snes_linesearch_armijo <1e-08> - Share of the predicted decrease to reach
.  -snes_linesearch_damping <1> - First step length to try (PETSc's own)
-  -snes_linesearch_max_it <100> - Most step lengths to try (PETSc's own)

   Level: intermediate
M*/
PetscErrorCode SNESLineSearchCreate_Trefoil(SNESLineSearch search) {
  PetscFunctionBegin;
  search->ops->apply = SNESLineSearchApply_Trefoil;
  search->ops->setfromoptions = SNESLineSearchSetFromOptions_Trefoil;
  search->ops->view = SNESLineSearchView_Trefoil;
  PetscCall(SNESLineSearchSetTolerances(search, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                                        PETSC_DEFAULT, PETSC_DEFAULT, 100));
  PetscFunctionReturn(PETSC_SUCCESS);
}
