#include "solve/solve.hpp"

#include <petsctime.h>

#include <sstream>
#include <utility>

#include "scene/initial_displacement.hpp"
#include "scene/unknown_options.hpp"
#include "solve/contact_path.hpp"
#include "solve/load_steps.hpp"
#include "solve/path.hpp"
#include "solve/path_choice.hpp"
#include "solve/run_record.hpp"
#include "solve/saved_numbers.hpp"
#include "solve/scene_solver.hpp"
#include "solve/set_linear_solver.hpp"
#include "solve/start.hpp"
#include "solve/start_check.hpp"
#include "solve/step_sizes.hpp"
#include "solve/time_walk.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

StepSizes step_sizes_of(const SceneOptions &options) {
  const PetscInt steps = number_of_load_steps(options);
  return steps > 0 ? StepSizes::equal(static_cast<int>(steps))
                   : StepSizes::adaptive(options.first_load_step, options.least_load_step);
}

/// The way from t = 0 to 1, step by step.
class Walk {
 public:
  Walk(Scene &scene, const StateObserver &observe, Checkpoint &checkpoint, SolveOutcome *outcome)
      : scene_(scene),
        observe_(observe),
        checkpoint_(checkpoint),
        outcome_(outcome),
        comm_(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))),
        sizes_(step_sizes_of(scene.options)),
        path_(scene),
        contact_(scene) {}

  PetscErrorCode go();

 private:
  [[nodiscard]] bool has_steps() const { return sizes_.count() != 1; }
  PetscErrorCode begin();
  PetscErrorCode save(SavedRun *run) const;
  PetscErrorCode go_on();
  PetscErrorCode say_step(double time) const;
  PetscErrorCode take_step(double time, Attempt *attempt);
  PetscErrorCode follow_friction(double head_start, bool is_last, Attempt *attempt);
  PetscErrorCode accept(double time, const Attempt &attempt);
  PetscErrorCode reject(double time, const Attempt &attempt, bool *goes_on);
  void record(const Attempt &attempt, bool is_rejected);

  Scene &scene_;
  const StateObserver &observe_;
  Checkpoint &checkpoint_;
  SolveOutcome *outcome_;
  MPI_Comm comm_;
  StepSizes sizes_;
  LoadPath path_;
  ContactPath contact_;
  bool goes_on_in_step_ = false;  ///< in the solve that the run was saved in
  bool is_broken_ = false;        ///< the last equilibrium was none: surfaces intersect in it
  RunRecord record_of_run_{"load_step"};
  PetscLogDouble begin_ = 0;
  PetscInt64 inverted_ = 0;  ///< elements, at the last equilibrium that stands
};

PetscErrorCode Walk::say_step(double time) const {
  PetscFunctionBeginUser;
  std::ostringstream text;  // PETSc would print "t = 1."
  text << "load step " << sizes_.accepted() + 1;
  if (!sizes_.is_adaptive()) text << " of " << sizes_.count();
  text << ", t = " << time;
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Walk::take_step(double time, Attempt *attempt) {
  PetscLogDouble now = 0;
  PetscFunctionBeginUser;
  if (has_steps()) {
    PetscCall(say_step(time));
    PetscCall(path_.go_to(time, &outcome_->guess));
  }
  if (!path_.has_stand() && !goes_on_in_step_) PetscCall(make_start(scene_, outcome_));
  PetscCall(PetscTime(&now));
  const double head_start = has_steps() ? now - begin_ : outcome_->guess.seconds;
  if (contact_.exists() && goes_on_in_step_) {
    PetscCall(contact_.go_on_in_step(checkpoint_, time));
  } else if (contact_.exists()) {
    PetscCall(contact_.move_to(time, attempt));
    if (!attempt->reason.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  }
  const AttemptOptions how{.head_start = head_start,
                           .may_fail = sizes_.is_adaptive(),
                           .goes_on = std::exchange(goes_on_in_step_, false),
                           .is_last = time == 1};
  PetscCall(solve_from_start(scene_, how, checkpoint_, *outcome_, attempt));
  if (contact_.exists()) PetscCall(follow_friction(head_start, time == 1, attempt));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves again with the friction of what was found, as often as the options want it.
PetscErrorCode Walk::follow_friction(double head_start, bool is_last, Attempt *attempt) {
  PetscFunctionBeginUser;
  while (attempt->converged) {
    bool again = false;
    PetscCall(contact_.repeats(attempt->iterations, &again));
    if (!again) break;
    record(*attempt, false);
    *attempt = {};
    const AttemptOptions how{.head_start = head_start, .may_fail = true, .is_last = is_last};
    PetscCall(solve_from_start(scene_, how, checkpoint_, *outcome_, attempt));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

void Walk::record(const Attempt &attempt, bool is_rejected) {
  if (!attempt.record.empty()) outcome_->linear_solver = attempt.linear_solver;
  record_of_run_.add(attempt.record, sizes_.accepted() + 1, is_rejected);
}

PetscErrorCode Walk::accept(double time, const Attempt &attempt) {
  constexpr PetscInt easy_iterations = 8;
  PetscFunctionBeginUser;
  if (contact_.exists()) {
    PetscCall(contact_.accept(time, &outcome_->failure));
    is_broken_ = !outcome_->failure.empty();
    if (is_broken_) PetscFunctionReturn(PETSC_SUCCESS);
    PetscCall(scene_.functional->accept_step(scene_.displacement));
  }
  record(attempt, false);
  inverted_ = attempt.inverted;
  if (has_steps()) PetscCall(path_.accept());
  sizes_.accept(attempt.iterations <= easy_iterations);
  PetscCall(observe_(time, attempt.iterations, false));
  if (time < 1) PetscCall(checkpoint_.pass(true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Back to the last equilibrium that stands. @param goes_on whether a shorter step is left
PetscErrorCode Walk::reject(double time, const Attempt &attempt, bool *goes_on) {
  PetscFunctionBeginUser;
  *goes_on = !attempt.is_hopeless && sizes_.halve();
  if (!*goes_on && attempt.converged) {  // elements are turned round however short the step is
    PetscCall(accept(time, attempt));
    *goes_on = true;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  // What counts of a way that ends here is how the last solve on it went.
  record(attempt, *goes_on);
  PetscCall(path_.go_back());
  std::ostringstream text;
  if (*goes_on) {
    text << "the step to t = " << time << " is halved: ";
  } else {
    text << "the load step from t = " << sizes_.time() << " to " << time << " failed: ";
  }
  if (attempt.converged) {
    text << "it turns " << attempt.inverted - inverted_ << " elements round";
  } else {
    text << attempt.reason;
  }
  if (*goes_on) {
    PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  } else {
    outcome_->failure = text.str();
    outcome_->is_hopeless = attempt.is_hopeless;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Walk::save(SavedRun *run) const {
  PetscFunctionBeginUser;
  run->numbers["steps"] = json_of(sizes_.reached());
  run->numbers["equal_steps"] = sizes_.count();
  run->numbers["inverted"] = inverted_;
  run->numbers["record"] = record_of_run_.save();
  save_start(*outcome_, run);
  PetscCall(path_.save(checkpoint_, run));
  if (contact_.exists()) contact_.save(run);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Walk::go_on() {
  int equal_steps = -1;
  PetscFunctionBeginUser;
  PetscCall(checkpoint_.take([&](const Checkpoint::Json &numbers) {
    equal_steps = numbers.at("equal_steps");
    sizes_.go_on(steps_reached_of(numbers.at("steps")));
    inverted_ = numbers.at("inverted");
    record_of_run_.load(numbers.at("record"));
    goes_on_in_step_ = numbers.contains("search");
  }));
  PetscCheck(equal_steps == sizes_.count(), comm_, PETSC_ERR_USER_INPUT,
             "%s is of a run with other -load_steps than %s: go on with the same",
             scene_.options.checkpoint.restart_file.c_str(), scene_.options.load_steps.c_str());
  PetscCall(load_start(checkpoint_, outcome_));
  PetscCall(path_.go_on(checkpoint_, false, &outcome_->guess));
  if (contact_.exists()) PetscCall(contact_.go_on(checkpoint_));
  if (!goes_on_in_step_) checkpoint_.end_start();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Walk::begin() {
  PetscFunctionBeginUser;
  if (has_steps()) PetscCall(path_.check(sizes_.next() < 1 ? sizes_.next() : 0.5, 1));
  PetscCall(PetscTime(&begin_));
  checkpoint_.save_way([this](SavedRun *run) { return save(run); });
  if (checkpoint_.start()) {
    PetscCall(go_on());
  } else if (contact_.exists()) {
    PetscCall(contact_.begin());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Walk::go() {
  bool goes_on = true;
  PetscFunctionBeginUser;
  PetscCall(begin());
  while (!sizes_.is_done() && goes_on && !is_broken_) {
    const double time = sizes_.next();
    Attempt attempt;
    PetscCall(take_step(time, &attempt));
    const bool turns_elements = sizes_.is_adaptive() && attempt.inverted > inverted_;
    if (attempt.converged && !turns_elements) {
      PetscCall(accept(time, attempt));
    } else if (has_steps()) {
      PetscCall(reject(time, attempt, &goes_on));
    } else {
      record(attempt, false);
      if (attempt.record.empty()) outcome_->failure = attempt.reason;
      outcome_->is_hopeless = attempt.is_hopeless;
      goes_on = false;
    }
  }
  outcome_->converged = sizes_.is_done();
  outcome_->time = has_steps() ? sizes_.time() : 1;
  outcome_->plugin_record = record_of_run_.text();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode solve_scene(Scene &scene, const StateObserver &observe, Checkpoint &checkpoint,
                           SolveOutcome *outcome) {
  EnergySums end;
  bool may_take = false;
  PetscFunctionBeginUser;
  PetscCall(scene.functional->energy_at_rest(&outcome->energy_rest));
  PetscCall(choose_linear_solver(scene, &scene.linear_solver));
  PetscCall(may_take_path(scene.options, &may_take));
  may_take = may_take && !scene.contact;  // a leap would pass through what is in the way
  if (scene.motion) {
    PetscCall(walk_in_time(scene, observe, checkpoint, outcome));
  } else if (may_take) {
    PetscCall(solve_by_leap_or_path(scene, observe, checkpoint, outcome));
  } else {
    PetscCall(Walk(scene, observe, checkpoint, outcome).go());
  }
  checkpoint.save_way({});
  PetscCall(scene.functional->energy(scene.displacement, &end));
  outcome->energy_scale = end.scale;
  PetscCall(scene.functional->count_inverted(scene.displacement, &outcome->inverted));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode expect_linear_solver(Scene &scene, LinearSolver *solver) {
  SceneSolver expected(scene);
  SolveOutcome outcome;
  PetscFunctionBeginUser;
  PetscCall(choose_linear_solver(scene, &scene.linear_solver));
  PetscCall(expected.set_up(outcome, 0));
  PetscCall(expected.expect(solver));
  if (scene.motion) PetscCall(scene.motion->hold_start());
  const std::string initial = choose_initial(scene.options);
  if (initial == "rest" || initial == "expression" || initial == "file") {  // which takes no solve
    EnergySums start;
    PetscCall(make_start(scene, &outcome));
    if (scene.motion) PetscCall(scene.motion->start());
    PetscCall(scene.functional->energy(scene.displacement, &start));
    if (scene.options.load_steps == "1") PetscCall(check_start(scene, start.energy));
  }
  // Other preconditioners than a factor read their options when they are set up.
  if (solver->factor_bytes > 0) {
    PetscCall(
        refuse_unused_of_solver(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
