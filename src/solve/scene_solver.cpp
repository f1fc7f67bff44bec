#include "solve/scene_solver.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "scene/element_pressure.hpp"
#include "scene/unknown_options.hpp"
#include "solve/saved_numbers.hpp"
#include "solve/set_linear_solver.hpp"
#include "solve/solver_defaults.hpp"
#include "solve/start_check.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {
namespace {

/// What the plugin says of MUMPS, which raises no error.
constexpr const char *no_memory_for_factors = "ran out of memory for its factors";

/// Refuses what PETSc would fail on late, or without a record.
PetscErrorCode check_solver(SNES snes) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  PetscBool keeps_record = PETSC_FALSE;
  PetscInt iterations = 0;
  SNESType type = nullptr;
  PetscFunctionBeginUser;
  PetscCall(SNESGetType(snes, &type));
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(snes), &keeps_record,
                                      SNESTREFOIL, SNESNEWTONLS, SNESNEWTONTR, ""));
  PetscCheck(keeps_record, comm, PETSC_ERR_USER_INPUT,
             "-snes_type %s cannot solve a scene; use trefoil, newtonls or newtontr", type);
  PetscCall(SNESGetTolerances(snes, nullptr, nullptr, nullptr, &iterations, nullptr));
  PetscCheck(iterations >= 0, comm, PETSC_ERR_USER_INPUT,
             "-snes_max_it is %" PetscInt_FMT " and must not be negative", iterations);
  PetscFunctionReturn(PETSC_SUCCESS);
}

EnergyFunctional::Assembly assembly_of(const SceneOptions &options) {
  if (options.assembly == "hook") return EnergyFunctional::Assembly::hook;
  return options.assembly == "plain" ? EnergyFunctional::Assembly::plain
                                     : EnergyFunctional::Assembly::split;
}

/// A monitor: when the first iteration has set up all solvers, what none of them has read is an
/// error.
PetscErrorCode refuse_unused_once(SNES snes, PetscInt iteration, PetscReal, void *) {
  PetscFunctionBeginUser;
  if (iteration == 1) {
    PetscCall(refuse_unused_of_solver(PetscObjectComm(reinterpret_cast<PetscObject>(snes))));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// CHOLMOD raises an error where a matrix is not positive definite; to a user that is a solve that
/// did not converge.
PetscErrorCode solve(SNES snes, Vec x) {
  PetscFunctionBeginUser;
  const PetscErrorCode error = SNESSolve(snes, nullptr, x);
  if (error == PETSC_ERR_MAT_CH_ZRPVT || error == PETSC_ERR_MAT_LU_ZRPVT) {
    PetscCall(TrefoilSNESEndSolve(snes, SNES_DIVERGED_LINEAR_SOLVE,
                                  "the linear solver met a matrix that is not positive definite"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(error);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// One line, before the first solve.
PetscErrorCode say_linear_solver(const Scene &scene, SNES snes) {
  LinearSolver solver;
  PetscFunctionBeginUser;
  PetscCall(describe_linear_solver(snes, &solver));
  PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(snes)),
                        "linear solver: %s (%s)\n", solver.text.c_str(),
                        scene.linear_solver.reason.c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

SceneSolver::~SceneSolver() {
  static_cast<void>(SNESDestroy(&snes_));  // an error has nowhere to go from here
}

PetscErrorCode SceneSolver::set_up(const SolveOutcome &outcome, double head_start) {
  PetscFunctionBeginUser;
  PetscCall(SNESCreate(PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm)), &snes_));
  PetscCall(scene_.functional->attach(snes_, scene_.hessian, assembly_of(scene_.options)));
  const bool trust = outcome.guess.linear_solves > 0 || outcome.inverted_at_start == 0;
  PetscCall(set_defaults(snes_));
  PetscCall(TrefoilSNESSetTrustStart(snes_, trust ? PETSC_TRUE : PETSC_FALSE));
  PetscCall(TrefoilSNESSetHeadStart(snes_, head_start));
  PetscCall(set_defaults_of_linear_solver(scene_.linear_solver, snes_));
  // An error dp of the pressure costs next to no energy, dp^2 / lambda, and all of it is in forces.
  if (element_pressure(scene_.options) == ElementPressure::constant) {
    PetscCall(TrefoilSNESSetTakeLast(snes_, PETSC_TRUE));
  }
  if (scene_.motion) PetscCall(set_time_defaults(snes_));
  PetscCall(SNESSetFromOptions(snes_));
  PetscCall(check_solver(snes_));
  if (scene_.motion) PetscCall(set_time_tests_of_others(snes_));
  PetscCall(TrefoilSNESSetFromOptions(snes_));     // also where another type does not read them
  PetscCall(TrefoilSNESSetRecordFile(snes_, ""));  // the program writes it, completed
  PetscCall(set_linear_solver(scene_, snes_));
  // Factors of H itself, which tell whether it is definite, need N; conjugate gradients do not.
  if (scene_.linear_solver.kind == SolverKind::iterative && scene_.options.assembly == "split") {
    PetscCall(scene_.functional->do_without_negative(snes_));
  }
  if (outcome.linear_solver.empty()) PetscCall(say_linear_solver(scene_, snes_));
  PetscCall(SNESMonitorSet(snes_, refuse_unused_once, nullptr, nullptr));
  PetscCall(progress_.watch(snes_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::set_direction_tolerance(double tolerance) {
  PetscBool given = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-snes_trefoil_direction_tolerance", &given));
  if (!given) PetscCall(TrefoilSNESSetDirectionTolerance(snes_, tolerance));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::loosen(double energy_tolerance) {
  PetscFunctionBeginUser;
  PetscCall(TrefoilSNESSetTolerances(snes_, 0, energy_tolerance));
  PetscCall(TrefoilSNESSetVerifyMinimum(snes_, PETSC_FALSE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::take_full_steps(PetscInt most, double residual_share,
                                            PetscErrorCode (*follow)(SNES, PetscInt, PetscReal,
                                                                     void *),
                                            void *context) {
  SNESLineSearch search = nullptr;
  PetscInt iterations = 0, functions = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESSetType(snes_, SNESNEWTONLS));
  PetscCall(SNESGetLineSearch(snes_, &search));
  PetscCall(SNESLineSearchSetType(search, "basic"));  // the constant has another name in 3.25
  PetscCall(TrefoilSNESSetFilter(snes_, "newton"));
  PetscCall(SNESGetTolerances(snes_, nullptr, nullptr, nullptr, &iterations, &functions));
  PetscCall(SNESSetTolerances(snes_, 0, residual_share, 0, std::min(most, iterations), functions));
  PetscCall(SNESMonitorSet(snes_, follow, context, nullptr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A monitor. Before the first step there is nothing to be saved but the start.
PetscErrorCode SceneSolver::pass_iteration(SNES, PetscInt iteration, PetscReal, void *context) {
  auto &solver = *static_cast<SceneSolver *>(context);
  Checkpoint::Part solve;
  PetscFunctionBeginUser;
  if (solver.saves_iterate_) {
    solve = [&](SavedRun *run) { return solver.save(*solver.checkpoint_, run); };
  }
  PetscCall(solver.checkpoint_->pass(solver.saves_iterate_ && iteration > 0, solve));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::watch(Checkpoint &checkpoint, bool saves_iterate) {
  PetscFunctionBeginUser;
  if (!checkpoint.is_on()) PetscFunctionReturn(PETSC_SUCCESS);
  checkpoint_ = &checkpoint;
  saves_iterate_ = saves_iterate;
  PetscCall(SNESMonitorSet(snes_, pass_iteration, this, nullptr));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::save(const Checkpoint &checkpoint, SavedRun *run) const {
  TrefoilSearchState state;
  PetscFunctionBeginUser;
  PetscCall(TrefoilSNESGetSearchState(snes_, &state));
  PetscCall(checkpoint.keep(scene_.displacement, "displacement", false, run));
  run->numbers["search"] = json_of(state);
  if (state.previous_step) {
    PetscCall(checkpoint.keep(state.previous_step, "previous_step", true, run));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::describe_search(Checkpoint::Json *numbers) const {
  TrefoilSearchState state;
  PetscFunctionBeginUser;
  PetscCall(TrefoilSNESGetSearchState(snes_, &state));
  *numbers = json_of(state);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::go_on(const Checkpoint &checkpoint) {
  TrefoilSearchState state{};
  Vec previous = nullptr;
  PetscFunctionBeginUser;
  PetscCall(checkpoint.take(
      [&](const Checkpoint::Json &numbers) { state = search_state_of(numbers.at("search")); }));
  if (checkpoint.start()->fields.count("previous_step")) {
    PetscCall(VecDuplicate(scene_.displacement, &previous));
    PetscCall(checkpoint.fetch("previous_step", previous));
    state.previous_step = previous;
  }
  PetscCall(TrefoilSNESSetSearchState(snes_, &state));
  PetscCall(VecDestroy(&previous));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode SceneSolver::solve(Attempt *attempt) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes_));
  const char *record = nullptr;
  LinearSolver linear;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt linear_iterations = 0;
  PetscFunctionBeginUser;
  PetscCall(trefoil::solve(snes_, scene_.displacement));
  PetscCall(SNESGetLinearSolveIterations(snes_, &linear_iterations));
  // There may have been no second iteration.
  if (linear_iterations > 0) PetscCall(refuse_unused_of_solver(comm));
  PetscCall(SNESGetConvergedReason(snes_, &reason));
  PetscCall(TrefoilSNESGetRecord(snes_, &record));
  PetscCall(describe_linear_solver(snes_, &linear));
  attempt->linear_solver = linear.text;
  attempt->converged = reason > 0;
  attempt->is_cut_short = reason == SNES_DIVERGED_MAX_IT;
  attempt->record = record;
  const auto json = nlohmann::json::parse(attempt->record, nullptr, false);
  PetscCheck(json.is_object(), comm, PETSC_ERR_PLIB, "the solver left no record");
  attempt->iterations = json["result"]["iterations"];
  attempt->reason = json["result"]["reason"];
  // As where CHOLMOD has raised an error: there is no memory for results either.
  PetscCheck(attempt->reason.find(no_memory_for_factors) == std::string::npos, comm, PETSC_ERR_MEM,
             "there is no memory for the factors");
  if (scene_.contact && !attempt->converged) PetscCall(explain_by_contact(attempt));
  PetscCall(scene_.functional->count_inverted(scene_.displacement, &attempt->inverted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where next to nothing is left between surfaces, that is why a solve failed.
PetscErrorCode SceneSolver::explain_by_contact(Attempt *attempt) const {
  constexpr double factor = 100;
  const double next_to_nothing = factor * scene_.contact->parameters().limits.touching;
  std::vector<double> u;
  std::ostringstream text;
  std::string pair;
  double gap = 0;
  PetscFunctionBeginUser;
  PetscCall(scene_.discretization.copy_local(scene_.displacement, &u));
  PetscCall(scene_.contact->find_gap(u.data(), next_to_nothing, &gap, &pair));
  if (!(gap < next_to_nothing)) PetscFunctionReturn(PETSC_SUCCESS);
  text << "contact is too weak for what presses: " << pair << " are only " << gap
       << " apart; a larger -contact_stiffness or -contact_distance, or shorter steps, keep them "
          "farther apart ("
       << attempt->reason << ")";
  attempt->reason = text.str();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode solve_from_start(Scene &scene, const AttemptOptions &options, Checkpoint &checkpoint,
                                const SolveOutcome &outcome, Attempt *attempt) {
  SceneSolver solver(scene);
  EnergySums start;
  PetscFunctionBeginUser;
  PetscCall(solver.set_up(outcome, options.head_start));
  PetscCall(solver.watch(checkpoint, options.is_saved));
  if (options.goes_on) {
    PetscCall(checkpoint.fetch("displacement", scene.displacement));
    PetscCall(solver.go_on(checkpoint));
    checkpoint.end_start();
  }
  if (options.loose_tolerance > 0) PetscCall(solver.loosen(options.loose_tolerance));
  PetscCall(scene.functional->energy(scene.displacement, &start));
  if (options.may_fail && !std::isfinite(start.energy)) {
    attempt->reason = "its start has infinite energy";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(check_start(scene, start.energy));
  PetscCall(solver.solve(attempt));
  if (options.is_last && attempt->converged) {
    PetscCall(checkpoint.save([&](SavedRun *run) { return solver.save(checkpoint, run); }));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
