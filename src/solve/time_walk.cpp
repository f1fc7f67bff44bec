#include "solve/time_walk.hpp"

#include <cmath>
#include <sstream>
#include <utility>

#include "solve/contact_path.hpp"
#include "solve/run_record.hpp"
#include "solve/saved_numbers.hpp"
#include "solve/scene_solver.hpp"
#include "solve/start.hpp"
#include "solve/start_check.hpp"
#include "solve/time_steps.hpp"
#include "solve/time_tolerance.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

class TimeWalk {
 public:
  TimeWalk(Scene &scene, const StateObserver &observe, Checkpoint &checkpoint,
           SolveOutcome *outcome)
      : scene_(scene),
        observe_(observe),
        checkpoint_(checkpoint),
        outcome_(outcome),
        comm_(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))),
        options_(scene.options.time),
        tolerance_(scene),
        steps_(*options_.end, *options_.step, options_.shortest_step()),
        solver_(scene),
        contact_(scene) {}

  PetscErrorCode go();

 private:
  PetscErrorCode start();
  PetscErrorCode save(SavedRun *run) const;
  PetscErrorCode say_end() const;
  PetscErrorCode go_on();
  PetscErrorCode say_step() const;
  PetscErrorCode solve_here(Attempt *attempt);
  PetscErrorCode move_prescribed(Attempt *attempt, bool *arrived);
  PetscErrorCode take_step(Attempt *attempt);
  PetscErrorCode reject(const Attempt &attempt, bool *goes_on);

  Scene &scene_;
  const StateObserver &observe_;
  Checkpoint &checkpoint_;
  SolveOutcome *outcome_;
  MPI_Comm comm_;
  const TimeOptions &options_;
  TimeTolerance tolerance_;
  TimeSteps steps_;
  SceneSolver solver_;
  ContactPath contact_;
  RunRecord record_{"time_step"};
  Checkpoint::Json search_;  ///< what the search knew when the last state came to stand
  std::vector<std::string> records_of_step_;  ///< of the step under way, a solve each
  PetscInt iterations_of_step_ = 0;
};

PetscErrorCode TimeWalk::start() {
  EnergySums sums;
  PetscFunctionBeginUser;
  PetscCall(scene_.motion->hold_start());
  PetscCall(make_start(scene_, outcome_));
  PetscCall(solver_.set_up(*outcome_, outcome_->guess.seconds));
  PetscCall(scene_.motion->start());
  if (contact_.exists()) PetscCall(contact_.begin());
  PetscCall(scene_.functional->energy(scene_.displacement, &sums));
  PetscCall(check_start(scene_, sums.energy));
  PetscCall(scene_.motion->accelerate());
  PetscCall(observe_(0, 0, false));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The last state that stands, also where a step is under way.
PetscErrorCode TimeWalk::save(SavedRun *run) const {
  const TimeIntegrator &integrator = scene_.motion->integrator();
  const Motion &previous = integrator.previous();
  PetscFunctionBeginUser;
  run->numbers["steps"] = json_of(steps_.reached());
  run->numbers["previous_step"] = integrator.previous_step();
  run->numbers["has_previous"] = !previous.u.empty();
  run->numbers["record"] = record_.save();
  if (!search_.is_null()) run->numbers["search"] = search_;
  save_start(*outcome_, run);
  run->fields["displacement"] = integrator.state().u;
  run->fields["velocity"] = integrator.state().v;
  run->fields["acceleration"] = integrator.state().a;
  if (!previous.u.empty()) {
    run->fields["previous_displacement"] = previous.u;
    run->fields["previous_velocity"] = previous.v;
  }
  if (contact_.exists()) contact_.save(run);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Of a run that goes on where it has ended already.
PetscErrorCode TimeWalk::say_end() const {
  const char *file = scene_.options.checkpoint.restart_file.c_str();
  std::ostringstream reached;
  PetscFunctionBeginUser;
  reached << steps_.time();
  PetscCheck(steps_.time() <= *options_.end, comm_, PETSC_ERR_USER_INPUT,
             "%s is at t = %s, behind -time_end %g: give a later end", file, reached.str().c_str(),
             *options_.end);
  if (steps_.is_done()) {
    PetscCall(PetscPrintf(comm_, "%s is at t = %s, the end: nothing is left to be solved\n", file,
                          reached.str().c_str()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimeWalk::go_on() {
  Motion state, previous;
  double previous_step = 0;
  bool has_previous = false, has_searched = false;
  EnergySums sums;
  PetscFunctionBeginUser;
  PetscCall(checkpoint_.take([&](const Checkpoint::Json &numbers) {
    steps_.go_on(steps_reached_of(numbers.at("steps")));
    previous_step = numbers.at("previous_step");
    has_previous = numbers.at("has_previous");
    record_.load(numbers.at("record"));
    has_searched = numbers.contains("search");
  }));
  PetscCall(say_end());
  PetscCall(load_start(checkpoint_, outcome_));
  PetscCall(checkpoint_.fetch("displacement", scene_.displacement));
  PetscCall(checkpoint_.fetch("displacement", &state.u));
  PetscCall(checkpoint_.fetch("velocity", &state.v));
  PetscCall(checkpoint_.fetch("acceleration", &state.a));
  if (has_previous) {
    PetscCall(checkpoint_.fetch("previous_displacement", &previous.u));
    PetscCall(checkpoint_.fetch("previous_velocity", &previous.v));
  }
  PetscCall(solver_.set_up(*outcome_, 0));
  PetscCall(
      scene_.motion->go_on(steps_.time(), std::move(state), std::move(previous), previous_step));
  if (contact_.exists()) PetscCall(contact_.go_on(checkpoint_));
  if (has_searched) PetscCall(solver_.go_on(checkpoint_));
  PetscCall(scene_.functional->energy(scene_.displacement, &sums));
  PetscCall(check_start(scene_, sums.energy));
  checkpoint_.end_start();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimeWalk::say_step() const {
  std::ostringstream text;
  PetscFunctionBeginUser;
  text << "time step " << steps_.accepted() + 1 << ", t = " << steps_.next();
  if (steps_.length() < *options_.step) text << ", of length " << steps_.length();
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// One of the solves of a step.
PetscErrorCode TimeWalk::solve_here(Attempt *attempt) {
  EnergySums sums;
  PetscFunctionBeginUser;
  PetscCall(scene_.functional->energy(scene_.displacement, &sums));
  attempt->converged = false;
  if (!std::isfinite(sums.energy)) {
    attempt->reason = "what is held moves so far that its start has infinite energy";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(solver_.solve(attempt));
  records_of_step_.push_back(attempt->record);
  iterations_of_step_ += attempt->iterations;
  outcome_->linear_solver = attempt->linear_solver;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Moves what is prescribed to the end of the step. Where bodies are in the way it goes as far as
/// it can, they make room, and it goes on; these solves are loose.
PetscErrorCode TimeWalk::move_prescribed(Attempt *attempt, bool *arrived) {
  constexpr double loose_share = 0.1;
  const double loose = loose_share * scene_.contact->parameters().distance;
  PetscFunctionBeginUser;
  PetscCall(solver_.set_direction_tolerance(loose));
  PetscCall(contact_.begin_step(steps_.next()));
  PetscCall(contact_.move_on(arrived, attempt));
  while (!*arrived && attempt->reason.empty()) {
    PetscCall(solve_here(attempt));
    if (!attempt->converged) break;
    PetscCall(contact_.move_on(arrived, attempt));
  }
  attempt->converged = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimeWalk::take_step(Attempt *attempt) {
  bool arrived = true, again = true;
  PetscFunctionBeginUser;
  records_of_step_.clear();
  iterations_of_step_ = 0;
  PetscCall(say_step());
  PetscCall(scene_.motion->begin_step(steps_.length(), steps_.next()));
  if (contact_.exists()) PetscCall(move_prescribed(attempt, &arrived));
  if (!arrived) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(solver_.set_direction_tolerance(tolerance_.of_step(steps_.length())));
  while (again) {
    PetscCall(solve_here(attempt));
    again = contact_.exists() && attempt->converged;
    if (again) PetscCall(contact_.repeats(attempt->iterations, &again));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Back to the last state that stands. @param goes_on whether a shorter step is left
PetscErrorCode TimeWalk::reject(const Attempt &attempt, bool *goes_on) {
  const double from = steps_.time(), to = steps_.next();
  std::ostringstream text;
  PetscFunctionBeginUser;
  *goes_on = !attempt.is_hopeless && steps_.halve();
  PetscCall(scene_.motion->go_back());
  if (*goes_on) {
    text << "the step to t = " << to << " is halved: " << attempt.reason;
    PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  text << "the step in time from t = " << from << " to " << to << " failed";
  if (!attempt.is_hopeless) {
    text << ", and -time_step_min " << options_.shortest_step()
         << " allows none of half its length";
  }
  text << ": " << attempt.reason;
  outcome_->failure = text.str();
  outcome_->is_hopeless = attempt.is_hopeless;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimeWalk::go() {
  bool goes_on = true;
  PetscFunctionBeginUser;
  checkpoint_.save_way([this](SavedRun *run) { return save(run); });
  PetscCall(checkpoint_.start() ? go_on() : start());
  PetscCall(solver_.watch(checkpoint_, false));
  if (!steps_.is_done()) PetscCall(PetscPrintf(comm_, "%s\n", tolerance_.text().c_str()));
  while (!steps_.is_done() && goes_on) {
    Attempt attempt;
    PetscCall(take_step(&attempt));
    for (const std::string &record : records_of_step_) {
      record_.add(record, steps_.accepted() + 1, !attempt.converged);
    }
    if (!attempt.converged) {
      PetscCall(reject(attempt, &goes_on));
      continue;
    }
    if (contact_.exists()) {
      PetscCall(contact_.accept(steps_.next(), &outcome_->failure));
      if (!outcome_->failure.empty()) break;
    }
    PetscCall(scene_.motion->accept(steps_.next()));
    steps_.accept();
    PetscCall(solver_.describe_search(&search_));
    PetscCall(observe_(steps_.time(), iterations_of_step_, false));
    PetscCall(checkpoint_.pass(true));
  }
  PetscCall(checkpoint_.save());
  outcome_->converged = steps_.is_done();
  outcome_->time = steps_.time();
  outcome_->plugin_record = record_.text();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode walk_in_time(Scene &scene, const StateObserver &observe, Checkpoint &checkpoint,
                            SolveOutcome *outcome) {
  PetscFunctionBeginUser;
  PetscCall(TimeWalk(scene, observe, checkpoint, outcome).go());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
