#include "snes/line.hpp"

#include <petscksp.h>

#include <cmath>

#include "search/boundary_values.hpp"
#include "search/energy_check.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/real_dot.hpp"

namespace trefoil {
namespace {

/// Refuses to drive what it does not know: types of SNES that use a line search in other ways.
PetscErrorCode check_driven(const Solver &solver, SNESLineSearch search) {
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
PetscErrorCode check_energies(const Solver &solver, bool has_objective) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(solver.snes));
  PetscFunctionBegin;
  PetscCheck(has_objective || solver.options.search.kind != TREFOIL_SEARCH_SUBSPACE, comm,
             PETSC_ERR_ARG_WRONGSTATE,
             "-snes_trefoil_search subspace compares energies: set one with SNESSetObjective(), or "
             "use -snes_trefoil_search armijo");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the objective is an energy at all, at the first point that tells.
PetscErrorCode examine_objective(Solver &solver, LineSearchState &state) {
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

}  // namespace

PetscErrorCode open_line(Solver &solver, SNESLineSearch search, LineSearchState &state) {
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

PetscErrorCode open_iteration(Solver &solver, const LineSearchState &state) {
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

}  // namespace trefoil
