#include "search/shamanskii.hpp"

#include <petscksp.h>

#include "search/step.hpp"
#include "search/subspace_minimisation.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// How many steps pay: many from factors, none from an iterative solver.
PetscErrorCode most_steps(const SearchOptions &options, KSP ksp, int *most) {
  constexpr int from_factors = 8;
  PetscBool direct = PETSC_FALSE;
  PetscFunctionBegin;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(ksp), KSPPREONLY, &direct));
  *most = options.shamanskii_steps;
  if (*most < 0) *most = direct ? from_factors : 0;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Makes the point that was reached the start of a new line, with the old Jacobian's direction.
PetscErrorCode restart_line(KSP ksp, LineSearchState &state, SolveRecord &record) {
  PetscInt iterations = 0;
  PetscFunctionBegin;
  const Phase phase = state.clock.switch_to(Phase::linear_solve);
  PetscCall(KSPSolve(ksp, state.residual, state.update));
  PetscCall(KSPGetIterationNumber(ksp, &iterations));
  record.krylov_iterations += static_cast<int>(iterations);
  ++record.linear_solves;
  state.clock.switch_to(phase);
  PetscCall(VecCopy(state.solution, state.x));
  state.energy = state.trial_energy;
  PetscCall(take_solvers_direction(state));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode take_shamanskii_steps(const SearchOptions &options, SNESLineSearch search,
                                     const FilteredJacobian &jacobian, SearchMemory &memory,
                                     LineSearchState &state, SolveRecord &record) {
  constexpr PetscInt most_trials = 5;
  const double first_decrease = state.energy - state.trial_energy;
  SNES snes = nullptr;
  KSP ksp = nullptr;
  int most = 0;
  PetscFunctionBegin;
  PetscCall(SNESLineSearchGetSNES(search, &snes));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(most_steps(options, ksp, &most));
  for (int k = 0; k < most && !state.truncated; ++k) {
    bool accepted = false;
    PetscCall(restart_line(ksp, state, record));
    if (!(state.slope < 0)) break;
    PetscCall(minimise_in_plane(jacobian, memory, state));
    PetscCall(backtrack(options, state, 1, most_trials, &accepted));
    record.current.trials += state.trials;
    if (!accepted) {
      PetscCall(stay(state));
      break;
    }
    PetscCall(take_step(search, state, memory));
    ++record.current.shamanskii_steps;
    // Once they gain little, a new Jacobian is worth its price.
    if (state.energy - state.trial_energy < options.shamanskii_gain * first_decrease) break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
