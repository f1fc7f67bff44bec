// The functions of trefoil.h that set up and ask an SNES, see their comments there.

#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"

using trefoil::Solver;
using trefoil::SolverOptions;

/// Takes changed options over, where they make sense.
template <class Change>
static PetscErrorCode change_options(SNES snes, Change change) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  SolverOptions changed = solver->options;
  change(changed);
  PetscCall(trefoil::check_options(snes, changed));
  solver->options = changed;
  PetscCall(solver->make_rule());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetFilter(SNES snes, const char name[]) {
  PetscFunctionBegin;
  PetscCall(change_options(snes, [=](SolverOptions &options) { options.filter = name; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetRhoTolerance(SNES snes, PetscReal tolerance) {
  PetscFunctionBegin;
  PetscCall(change_options(
      snes, [=](SolverOptions &options) { options.rule.rho_tolerance = tolerance; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetConstantWeight(SNES snes, PetscReal weight) {
  PetscFunctionBegin;
  PetscCall(change_options(snes, [=](SolverOptions &options) { options.rule.weight = weight; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetSearch(SNES snes, TrefoilSearch search) {
  PetscFunctionBegin;
  PetscCall(change_options(snes, [=](SolverOptions &options) { options.search.kind = search; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetCorrections(SNES snes, PetscInt most) {
  PetscFunctionBegin;
  PetscCall(change_options(snes, [=](SolverOptions &options) {
    options.search.shamanskii_steps = static_cast<int>(most);
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetNewtonSteps(SNES snes, PetscInt most) {
  PetscFunctionBegin;
  PetscCall(change_options(
      snes, [=](SolverOptions &options) { options.search.newton_steps = static_cast<int>(most); }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetTrustStart(SNES snes, PetscBool trust) {
  PetscFunctionBegin;
  PetscCall(change_options(
      snes, [=](SolverOptions &options) { options.search.trust_start = trust == PETSC_TRUE; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetTolerances(SNES snes, PetscReal decrement, PetscReal energy) {
  constexpr auto keep = static_cast<PetscReal>(PETSC_DEFAULT);
  PetscFunctionBegin;
  PetscCall(change_options(snes, [=](SolverOptions &options) {
    if (decrement != keep) options.stop.decrement_tolerance = decrement;
    if (energy != keep) options.stop.energy_tolerance = energy;
    options.stop.energy_tolerance_set = options.stop.energy_tolerance_set || energy != keep;
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetProxy(SNES snes, TrefoilProxy proxy) {
  PetscFunctionBegin;
  PetscCall(change_options(snes, [=](SolverOptions &options) { options.search.proxy = proxy; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetContinue(SNES snes, PetscBool goes_on) {
  PetscFunctionBegin;
  PetscCall(change_options(
      snes, [=](SolverOptions &options) { options.search.goes_on = goes_on == PETSC_TRUE; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetDirectionTolerance(SNES snes, PetscReal tolerance) {
  PetscFunctionBegin;
  PetscCall(change_options(
      snes, [=](SolverOptions &options) { options.stop.direction_tolerance = tolerance; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetTakeLast(SNES snes, PetscBool take) {
  PetscFunctionBegin;
  PetscCall(change_options(
      snes, [=](SolverOptions &options) { options.stop.takes_last = take == PETSC_TRUE; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetVerifyMinimum(SNES snes, PetscBool verify) {
  PetscFunctionBegin;
  PetscCall(change_options(
      snes, [=](SolverOptions &options) { options.stop.verify_minimum = verify == PETSC_TRUE; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetVerifyShare(SNES snes, PetscReal share) {
  PetscFunctionBegin;
  PetscCall(
      change_options(snes, [=](SolverOptions &options) { options.stop.verify_share = share; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetMonitor(SNES snes, PetscBool on) {
  PetscFunctionBegin;
  PetscCall(
      change_options(snes, [=](SolverOptions &options) { options.monitor = on == PETSC_TRUE; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetRecordFile(SNES snes, const char path[]) {
  PetscFunctionBegin;
  PetscCall(change_options(snes, [=](SolverOptions &options) { options.record_file = path; }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetFromOptions(SNES snes) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  PetscCall(solver->set_from_options());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESJacobianMayBeIndefinite(SNES snes, PetscBool *may) {
  Solver *solver = nullptr;
  bool driven = false;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  PetscCall(trefoil::is_driven(snes, &driven));
  *may = driven && solver->rule->least_weight() >= 0.5 ? PETSC_FALSE : PETSC_TRUE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESRetriesFactors(SNES snes, PetscBool *retries) {
  Solver *solver = nullptr;
  bool driven = false;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  PetscCall(trefoil::is_driven(snes, &driven));
  *retries = driven && solver->rule->may_be_rejected() ? PETSC_TRUE : PETSC_FALSE;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESSetHeadStart(SNES snes, PetscReal seconds) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->record.head_start = seconds;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESEndSolve(SNES snes, SNESConvergedReason converged_reason,
                                   const char reason[]) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  solver->record.reason = reason;
  PetscCall(SNESSetConvergedReason(snes, converged_reason));
  PetscCall(solver->end_solve());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetWeight(SNES snes, PetscReal *weight) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  *weight = solver->record.current.weight;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetDecrementRatio(SNES snes, PetscReal *ratio) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  const trefoil::StopOptions &stop = solver->options.stop;
  const auto &history = solver->record.history;
  const double end = stop.decrement_tolerance > 0
                         ? stop.decrement_tolerance
                         : stop.energy_tolerance * solver->record.energy_scale;
  *ratio = history.empty() ? trefoil::IterationRecord::none : history.back().decrement / end;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetTrustRegionRatio(SNES snes, PetscReal *rho) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  const auto &history = solver->record.history;
  *rho = trefoil::IterationRecord::none;
  // A last entry without a step closes the history; the ratio belongs to the step before it.
  for (auto entry = history.rbegin(); entry != history.rend(); ++entry) {
    if (entry->step == 0) continue;
    *rho = entry->rho;
    break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilSNESGetRecord(SNES snes, const char **json) {
  Solver *solver = nullptr;
  PetscFunctionBegin;
  PetscCall(trefoil::get_solver(snes, &solver));
  *json = solver->json.c_str();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TrefoilGetOptionsManual(const char **lines) {
  static const std::string manual = trefoil::manual_of_options();
  PetscFunctionBegin;
  *lines = manual.c_str();
  PetscFunctionReturn(PETSC_SUCCESS);
}
