/*
   The line search `trefoil`. It is called with the direction d = -Y that the filtered Jacobian
   gave, decides whether the solve ends here, and otherwise takes a step along d:

     stop test on the Newton decrement |g'd| / 2, before the step is taken
     s = 1, 0.8, 0.64, ...  until  f(x + s d) <= f(x) + c s g'd           (Armijo)
     rho = (f(x) - f(x + u)) / -(g'u + u'Hu/2),   u = s d                 (trust-region ratio)

   with u'Hu = u'(H + 2 w N) u - 2 w u'N u: the unfiltered model costs two products, no assembly.

   With -snes_trefoil_search subspace the search begins at the energy's minimum in the plane of d
   and the previous step, and the step is corrected by further directions from the same factors.
*/
#include <petsc/private/linesearchimpl.h>
#include <petsc/private/snesimpl.h>

#include <cmath>

#include "search/line.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Ends the solve with `reason`, x as it is, and closes the history.
PetscErrorCode finish(SolveContext &context, SNESLineSearch search, SNESConvergedReason reason) {
  PetscFunctionBeginUser;
  context.snes->reason = reason;
  PetscCall(SNESLineSearchSetReason(
      search, reason > 0 ? SNES_LINESEARCH_SUCCEEDED : SNES_LINESEARCH_FAILED_REDUCT));
  context.history.push_back(context.current);
  PetscCall(monitor_iteration(context, context.current));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace
}  // namespace trefoil

using namespace trefoil;

/// Opens the iteration: what is known at x before anything is tried.
static PetscErrorCode open_line(SolveContext &context, SNESLineSearch search, Line &line) {
  IterationRecord &current = context.current;
  PetscErrorCode (*objective)(SNES, Vec, PetscReal *, void *) = nullptr;
  PetscScalar slope = 0;
  PetscInt iteration = 0, linear_iterations = 0;
  PetscBool changed = PETSC_FALSE;
  KSP ksp = nullptr;

  PetscFunctionBegin;
  PetscCall(SNESGetObjective(context.snes, &objective, nullptr));
  line.has_objective = objective != nullptr;
  PetscCheck(context.running && context.driven,
             PetscObjectComm(reinterpret_cast<PetscObject>(search)), PETSC_ERR_ORDER,
             "line search trefoil has not seen the Jacobian being made (were the SNES's monitors "
             "cancelled?): use -snes_type trefoil");
  PetscCheck(line.has_objective || context.options.search != "subspace",
             PetscObjectComm(reinterpret_cast<PetscObject>(search)), PETSC_ERR_ARG_WRONGSTATE,
             "-snes_trefoil_search subspace compares energies: set one with SNESSetObjective(), or "
             "use -snes_trefoil_search armijo");
  PetscCall(SNESLineSearchGetVecs(search, &line.solution, &line.residual, &line.minus_d,
                                  &line.trial, &line.trial_residual));
  PetscCall(SNESLineSearchPreCheck(search, line.solution, line.minus_d, &changed));
  // Callbacks that copy their argument into a vector of theirs often have the solution for it: in
  // the manner of dolfinx's own SNES test. Trial points would then move the point they start from.
  line.x = search->work[0];
  line.point = search->work[1];
  line.point_residual = search->work[2];
  PetscCall(SNESGetKSP(context.snes, &ksp));
  PetscCall(KSPGetIterationNumber(ksp, &linear_iterations));
  PetscCall(VecDot(line.residual, line.minus_d, &slope));
  line.slope = -PetscRealPart(slope);
  context.clock.switch_to(Phase::line_search);  // ranks have waited for each other's solve
  PetscCall(energy_at(context, line.solution, &line.energy));
  PetscCall(VecCopy(line.solution, line.x));
  if (context.boundary_values_open) {
    Mat H = nullptr;
    PetscCall(SNESGetJacobian(context.snes, nullptr, &H, nullptr, nullptr));
    PetscCall(moves_boundary_values(H, line.minus_d, &line.lifted));
    context.boundary_values_open = line.lifted;
  }

  if (!context.jacobian_is_new) {  // the SNES lags it
    ++context.summary.iterations;
    ++context.summary.linear_solves;
  }
  context.jacobian_is_new = false;
  PetscCall(SNESGetIterationNumber(context.snes, &iteration));
  current.k = static_cast<int>(iteration);
  current.energy = line.energy;
  current.decrement = std::abs(line.slope) / 2;
  current.linear_iterations = static_cast<int>(linear_iterations);
  current.linear_solves = context.summary.linear_solves;
  current.rho = IterationRecord::none;
  current.step = 0;
  current.trials = 0;
  current.corrections = 0;
  current.seconds = context.head_start + context.clock.elapsed();
  PetscCall(VecNorm(line.residual, NORM_2, &current.gradient_norm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Searches, takes the step found, corrects it where the search does that, and closes the iteration
/// with its trust-region ratio.
static PetscErrorCode search_and_step(SolveContext &context, SNESLineSearch search, Line &line) {
  IterationRecord &current = context.current;
  PetscInt most_trials = 0;
  PetscReal first_step = 0;
  double curvature = 0;
  bool accepted = false;

  PetscFunctionBegin;
  PetscCall(SNESLineSearchGetTolerances(search, nullptr, nullptr, nullptr, nullptr, nullptr,
                                        &most_trials));
  PetscCall(SNESLineSearchGetDamping(search, &first_step));
  const bool in_plane = searches_plane(context, line);
  if (in_plane) PetscCall(steer_direction(context, line));
  PetscCall(unfiltered_curvature(context, line, line.point, &curvature));
  PetscCall(backtrack(context, line, first_step, most_trials, &accepted));
  current.trials = line.trials;
  if (!accepted) {
    context.summary.reason = "no step along the direction decreases the energy";
    PetscCall(stay(context, line));
    PetscCall(finish(context, search, SNES_DIVERGED_LINE_SEARCH));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  current.step = line.share * line.step;
  if (!line.lifted) PetscCall(trust_region_ratio(context, line, curvature, &current.rho));
  PetscCall(take_step(context, search, line));
  if (in_plane) PetscCall(correct_step(context, search, line));
  context.history.push_back(current);
  PetscCall(monitor_iteration(context, current));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Ends the solve where the stop test is met, unless that point is a saddle that can be left.
static PetscErrorCode finish_or_leave(SolveContext &context, SNESLineSearch search, Line &line) {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscFunctionBegin;
  PetscCall(verify_minimum(context, line, &reason));
  if (reason) {
    PetscCall(finish(context, search, reason));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  context.current.step = line.step;
  context.current.trials = line.trials;
  PetscCall(take_step(context, search, line));
  context.history.push_back(context.current);
  PetscCall(monitor_iteration(context, context.current));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESLineSearchApply_Trefoil(SNESLineSearch search) {
  SNES snes = nullptr;
  SolveContext *context = nullptr;
  Line line{};
  SNESConvergedReason refused = SNES_CONVERGED_ITERATING;
  bool stop = false;

  PetscFunctionBegin;
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(get_solve_context(snes, &context));
  PetscCall(begin_solve(*context));
  PetscCall(PetscLogEventBegin(event_search, search, nullptr, nullptr, nullptr));
  PetscCall(open_line(*context, search, line));
  PetscCall(judge_direction(*context, line, &refused));
  if (refused) {
    PetscCall(finish(*context, search, refused));
  } else {
    if (!line.lifted) PetscCall(stop_test(*context, line.x, &stop));
    if (stop) {
      PetscCall(finish_or_leave(*context, search, line));
    } else {
      PetscCall(search_and_step(*context, search, line));
    }
  }
  PetscCall(PetscLogEventEnd(event_search, search, nullptr, nullptr, nullptr));
  context->clock.switch_to(Phase::other);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// SNES calls its monitors before each Jacobian: the place to see to it that ours is the one that
/// is called, whatever the host has set since.
static PetscErrorCode before_jacobian(SNES, PetscInt, PetscReal, void *context) {
  PetscFunctionBegin;
  PetscCall(install_jacobian(*static_cast<SolveContext *>(context)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESLineSearchSetFromOptions_Trefoil(SNESLineSearch search,
                                                           TrefoilOptionItems) {
  SNES snes = nullptr;
  SolveContext *context = nullptr;
  PetscFunctionBegin;
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(get_solve_context(snes, &context));
  PetscCall(set_options(*context));
  PetscCall(SNESMonitorSet(snes, before_jacobian, context, nullptr));  // once, PETSc compares
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESLineSearchSetUp_Trefoil(SNESLineSearch search) {
  PetscFunctionBegin;
  constexpr PetscInt count = 3;
  if (!search->work) PetscCall(SNESLineSearchSetWorkVecs(search, count));
  search->nwork = count;  // PETSc does not count them and so would never destroy them
  PetscFunctionReturn(PETSC_SUCCESS);
}

static PetscErrorCode SNESLineSearchView_Trefoil(SNESLineSearch search, PetscViewer viewer) {
  SNES snes = nullptr;
  SolveContext *context = nullptr;
  PetscBool ascii = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(
      PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &ascii));
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(get_solve_context(snes, &context));
  if (ascii) PetscCall(view_options(*context, viewer));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/*MC
   SNESLINESEARCHTREFOIL - backtracking on the energy along the eigenvalue-filtered direction

   Options Database Keys:
+  -snes_trefoil_filter <adaptive>               - newton, clamp, absolute, adaptive, constant,
                                                   on_demand, blend, three_state, multiplicative,
                                                   tikhonov
.  -snes_trefoil_rho_tolerance <0.01>            - adaptive: clamp while |rho - 1| is below
.  -snes_trefoil_weight <1>                      - constant: w of H + 2 w N
.  -snes_trefoil_floor <-1>                      - least eigenvalue of a filtered element, as a
                                                   share of its largest; negative: the filter's own
.  -snes_trefoil_space <element>                 - what is filtered: element, or deformation, dP/dF
                                                   at the quadrature points
.  -snes_trefoil_fields <all>                    - fields to filter, by name or number
.  -snes_trefoil_strict <true>                   - a Jacobian that cannot be filtered is an error
.  -snes_trefoil_search <armijo>                 - armijo, along the direction; subspace, in the
                                                   plane of it and the previous step
.  -snes_trefoil_corrections <-1>                - subspace: most further directions an iteration;
                                                   -1: 8 where the linear solver is direct, else 0
.  -snes_trefoil_correction_gain <0.03>          - subspace: least share of the first step's
                                                   decrease to go on correcting
.  -snes_trefoil_trust_start <false>             - subspace: from the first iteration; false: once
                                                   |rho - 1| is small
.  -snes_trefoil_decrement_tolerance <0>         - stop on the Newton decrement, energy units
.  -snes_trefoil_energy_tolerance <1e-8>         - stop on the decrement over the energy scale
.  -snes_trefoil_verify_minimum <false>          - leave a saddle along negative curvature where the
                                                   stop test is met
.  -snes_trefoil_monitor <false>                 - one line an iteration
.  -snes_trefoil_record <file>                   - JSON record of the solve
.  -snes_linesearch_damping <1>                  - first step length to try
.  -snes_linesearch_shrink <0.8>                 - factor between step lengths
.  -snes_linesearch_armijo <1e-8>                - share of the predicted decrease to reach
-  -snes_linesearch_max_it <100>                 - most step lengths to try

   Level: intermediate
M*/
PetscErrorCode SNESLineSearchCreate_Trefoil(SNESLineSearch search) {
  PetscFunctionBegin;
  search->ops->apply = SNESLineSearchApply_Trefoil;
  search->ops->setfromoptions = SNESLineSearchSetFromOptions_Trefoil;
  search->ops->setup = SNESLineSearchSetUp_Trefoil;
  search->ops->view = SNESLineSearchView_Trefoil;
  PetscCall(SNESLineSearchSetTolerances(search, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                                        PETSC_DEFAULT, PETSC_DEFAULT, 100));
  PetscFunctionReturn(PETSC_SUCCESS);
}
