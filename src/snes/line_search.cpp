/*
   The line search `trefoil` as PETSc knows it: its type, its options and its manual page.
   iteration.cpp has what it does.
*/
#include <petsc/private/linesearchimpl.h>

#include "snes/iteration.hpp"
#include "snes/solver.hpp"
#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"

using namespace trefoil;

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
