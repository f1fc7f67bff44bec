#include "snes/solver.hpp"

#include <petscksp.h>

#include <algorithm>

#include "search/linear_failure.hpp"
#include "snes/json_record.hpp"
#include "snes/monitor.hpp"
#include "support/notice.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {

TREFOIL_CONTEXT_DESTROY(destroy_solver, stored) {
  PetscFunctionBeginUser;
  delete TREFOIL_CONTEXT_OF(Solver, stored);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// PETSc calls this at the end of every SNESSolve, whatever SNES type drives our line search.
static PetscErrorCode end_of_solve(SNES, void *solver) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<Solver *>(solver)->end_solve());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode get_solver(SNES snes, Solver **solver) {
  constexpr const char *key = "trefoil_solver";
  PetscContainer container = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectQuery(reinterpret_cast<PetscObject>(snes), key,
                             reinterpret_cast<PetscObject *>(&container)));
  if (container) {
    void *stored = nullptr;
    PetscCall(PetscContainerGetPointer(container, &stored));
    *solver = static_cast<Solver *>(stored);
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  auto *made = new Solver(snes);
  PetscCall(PetscContainerCreate(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), &container));
  PetscCall(PetscContainerSetPointer(container, made));
  PetscCall(PetscContainerSetCtxDestroy(container, destroy_solver));
  PetscCall(PetscObjectCompose(reinterpret_cast<PetscObject>(snes), key,
                               reinterpret_cast<PetscObject>(container)));
  PetscCall(PetscContainerDestroy(&container));
  PetscCall(SNESConvergedReasonViewSet(snes, end_of_solve, made, nullptr));
  PetscCall(made->make_rule());
  *solver = made;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode is_driven(SNES snes, bool *driven) {
  PetscBool newton = PETSC_FALSE, ours = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(snes), &newton, SNESNEWTONLS,
                                      SNESTREFOIL, ""));
  if (newton) {
    SNESLineSearch search = nullptr;
    PetscCall(SNESGetLineSearch(snes, &search));
    PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(search), SNESLINESEARCHTREFOIL,
                                     &ours));
  }
  *driven = ours == PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Solver::begin_solve() {
  PetscFunctionBeginUser;
  if (record.running) PetscFunctionReturn(PETSC_SUCCESS);
  record.begin();
  record.notes = idle_options;
  jacobian.begin_solve();
  jacobian_is_new = proxy_is_formed = false;
  energy.begin_solve();
  // A split callback knows no Dirichlet rows.
  if (!resumes) PetscCall(memory.begin_solve(options.search, !split_jacobian));
  goes_on = resumes || options.search.goes_on;
  resumes = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Solver::close_iteration(const IterationRecord &iteration) {
  PetscFunctionBeginUser;
  record.history.push_back(iteration);
  if (options.monitor) {
    PetscCall(print_iteration(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), iteration,
                              energy.offset));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Solver::note(const std::string &sentence) {
  auto &notes = record.notes;
  PetscFunctionBeginUser;
  if (std::find(notes.begin(), notes.end(), sentence) == notes.end()) notes.push_back(sentence);
  PetscCall(say_once(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), sentence));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Why the SNES ended, where the search has not said it already.
static PetscErrorCode explain(SNES snes, SNESConvergedReason reason, std::string *text) {
  const char *name = nullptr;
  PetscFunctionBeginUser;
  if (!text->empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(SNESGetConvergedReasonString(snes, &name));
  *text = name;
  if (reason == SNES_DIVERGED_MAX_IT) {
    *text = "DIVERGED_MAX_IT: no tolerance is met after -snes_max_it iterations";
  }
  if (reason == SNES_DIVERGED_LINEAR_SOLVE) {
    KSP ksp = nullptr;
    PetscCall(SNESGetKSP(snes, &ksp));
    *text = "the linear solver failed";
    PetscCall(explain_linear_failure(ksp, text));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// After the last step, where PETSc's own tests ended the solve, the history still lacks the state
/// that was reached.
static PetscErrorCode close_history(Solver &solver, Vec x) {
  const SolveRecord &record = solver.record;
  Vec residual = nullptr;
  IterationRecord last;
  PetscFunctionBeginUser;
  if (!record.history.empty() && record.history.back().step == 0 && solver.driven) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  last.k = record.history.empty() ? 0 : record.history.back().k + 1;
  last.weight = record.current.weight;
  last.indefinite = IterationRecord::none;
  last.linear_solves = record.linear_solves;
  last.seconds = record.seconds();
  PetscCall(solver.energy.at(x, &last.energy));
  PetscCall(SNESGetFunction(solver.snes, &residual, nullptr, nullptr));
  PetscCall(VecNorm(residual, NORM_2, &last.gradient_norm));
  PetscCall(solver.close_iteration(last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Solver::end_solve() {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  Vec x = nullptr;
  PetscFunctionBeginUser;
  if (!record.running) PetscFunctionReturn(PETSC_SUCCESS);
  record.clock.switch_to(Phase::other);
  PetscCall(jacobian_test.restore(snes));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  record.converged = reason > 0;
  PetscCall(explain(snes, reason, &record.reason));
  PetscCall(SNESGetSolution(snes, &x));
  PetscCall(close_history(*this, x));
  if (energy.scale_callback) PetscCall(energy.scale(x, &record.energy_scale));
  record.clock.switch_to(Phase::other);
  PetscCall(make_json_record(snes, driven ? options.filter : "none", jacobian, record,
                             energy.offset, &json));
  if (!options.record_file.empty()) {
    PetscCall(write_text_file(PetscObjectComm(reinterpret_cast<PetscObject>(snes)),
                              options.record_file, json + "\n"));
  }
  record.running = false;
  for (const IterationRecord &entry : record.history) {
    if (entry.step > 0 && !entry.truncated) last_lesson = entry;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Solver::allow_linear_failures(bool allowed) {
  PetscOptions database = nullptr;
  const char *prefix = nullptr;
  PetscBool given = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(snes), &database));
  PetscCall(SNESGetOptionsPrefix(snes, &prefix));
  PetscCall(PetscOptionsHasName(database, prefix, "-snes_max_linear_solve_fail", &given));
  if (given) PetscFunctionReturn(PETSC_SUCCESS);
  if (allowed && !linear_failures) {
    PetscInt failures = 0;
    PetscCall(SNESGetMaxLinearSolveFailures(snes, &failures));
    PetscCall(SNESSetMaxLinearSolveFailures(snes, PETSC_MAX_INT));
    linear_failures = failures;
  } else if (!allowed && linear_failures) {
    PetscCall(SNESSetMaxLinearSolveFailures(snes, *linear_failures));
    linear_failures.reset();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Solver::make_rule() {
  PetscFunctionBeginUser;
  options.rule.solver = snes;
  rule = trefoil::make_rule(options.filter, options.rule);
  PetscCall(allow_linear_failures(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Solver::set_from_options() {
  const std::string fields = options.fields;
  PetscFunctionBeginUser;
  PetscCall(read_options(snes, &options, &idle_options));
  for (const std::string &sentence : idle_options) {
    PetscCall(say_once(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), sentence));
  }
  if (!options.record_file.empty()) {
    PetscCall(
        check_text_file(PetscObjectComm(reinterpret_cast<PetscObject>(snes)), options.record_file));
  }
  // The host's Mat knows the unknowns of the old fields.
  if (options.fields != fields) PetscCall(host_jacobian.release(jacobian));
  PetscCall(make_rule());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
