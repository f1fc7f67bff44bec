// What a solve carries from one iteration to the next, given to hosts and taken back.

#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"

using trefoil::IterationRecord;
using trefoil::Solver;
using trefoil::Work;

TrefoilIteration trefoil::as_hosts_see(const IterationRecord &iteration) {
  return {iteration.k,    iteration.energy, iteration.weight,    iteration.rho,
          iteration.step, iteration.trials, iteration.decrement, iteration.indefinite};
}

PetscErrorCode TrefoilSNESGetSearchState(SNES snes, TrefoilSearchState *state) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  const bool running = solver->record.running;
  const IterationRecord *last = running ? solver->record.last_lesson() : nullptr;
  if (!last && (!running || solver->goes_on) && solver->last_lesson) last = &*solver->last_lesson;
  *state = {};
  state->has_last = last ? PETSC_TRUE : PETSC_FALSE;
  if (last) state->last = trefoil::as_hosts_see(*last);
  state->trusts_model = solver->memory.trusts_model ? PETSC_TRUE : PETSC_FALSE;
  state->proxy_scale = solver->memory.proxy_scale;
  state->refused_decrement = solver->rule->refused_decrement();
  if (solver->memory.previous_step_known) {
    PetscCall(solver->memory.vectors.get(Work::previous_step, nullptr, &state->previous_step));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetSearchState(SNES snes, const TrefoilSearchState *state) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  PetscCheck(!solver->record.running, PetscObjectComm(reinterpret_cast<PetscObject>(snes)),
             PETSC_ERR_ORDER, "a solve is running; set what it goes on from before SNESSolve()");
  trefoil::SearchMemory &memory = solver->memory;
  PetscCall(memory.begin_solve(solver->options.search, !solver->split_jacobian));
  solver->resumes = true;
  solver->last_lesson.reset();
  if (state->has_last) {
    IterationRecord last;
    const TrefoilIteration &seen = state->last;
    last.k = static_cast<int>(seen.k);
    last.energy = seen.energy;
    last.weight = seen.weight;
    last.rho = seen.rho;
    last.step = seen.step;
    last.trials = static_cast<int>(seen.trials);
    last.decrement = seen.decrement;
    last.indefinite = seen.indefinite;
    solver->last_lesson = last;
  }
  memory.trusts_model = memory.trusts_model || state->trusts_model;
  memory.proxy_scale = state->proxy_scale;
  solver->rule->set_refused_decrement(state->refused_decrement);
  memory.previous_step_known = memory.keeps_steps && state->previous_step;
  if (memory.previous_step_known) {
    Vec own = nullptr;
    PetscCall(memory.vectors.get(Work::previous_step, state->previous_step, &own));
    PetscCall(VecCopy(state->previous_step, own));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}
