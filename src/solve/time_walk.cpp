#include "solve/time_walk.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "solve/contact_path.hpp"
#include "solve/run_record.hpp"
#include "solve/scene_solver.hpp"
#include "solve/start_check.hpp"
#include "solve/time_steps.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The velocity below which a step's directions need not go on. Friction holds by slips of less
/// than its slip velocity: the solver must resolve those, or it ends at rest where bodies slide.
double tolerated_velocity(const Scene &scene) {
  constexpr double share_of_slip = 0.03;
  const double asked = scene.options.time.tolerated_velocity(box_of(scene.mesh).diagonal());
  if (!scene.contact || !scene.contact->has_friction()) return asked;
  return std::min(asked, share_of_slip * scene.contact->parameters().slip_velocity);
}

class TimeWalk {
 public:
  TimeWalk(Scene &scene, const StateObserver &observe, SolveOutcome *outcome)
      : scene_(scene),
        observe_(observe),
        outcome_(outcome),
        comm_(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))),
        options_(scene.options.time),
        tolerated_velocity_(tolerated_velocity(scene)),
        steps_(*options_.end, *options_.step, options_.shortest_step()),
        solver_(scene),
        contact_(scene) {}

  PetscErrorCode go();

 private:
  PetscErrorCode start();
  PetscErrorCode say_tolerance() const;
  PetscErrorCode set_tolerance(double length);
  PetscErrorCode say_step() const;
  PetscErrorCode take_step(Attempt *attempt);
  PetscErrorCode reject(const Attempt &attempt, bool *goes_on);

  Scene &scene_;
  const StateObserver &observe_;
  SolveOutcome *outcome_;
  MPI_Comm comm_;
  const TimeOptions &options_;
  double tolerated_velocity_;
  TimeSteps steps_;
  SceneSolver solver_;
  ContactPath contact_;
  RunRecord record_{"time_step"};
  double tolerated_length_ = 0;  ///< of the step that the solver's tolerance is for
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

PetscErrorCode TimeWalk::say_tolerance() const {
  const bool is_absolute = options_.absolute_velocity_tolerance.has_value();
  const double asked = options_.tolerated_velocity(box_of(scene_.mesh).diagonal());
  std::ostringstream text;
  PetscFunctionBeginUser;
  if (tolerated_velocity_ > 0) {
    text << "a step in time ends where the direction over its length is below "
         << tolerated_velocity_;
    if (tolerated_velocity_ < asked) {
      text << " (a share of -contact_slip_velocity, which friction needs)";
    } else if (is_absolute) {
      text << " (-time_velocity_tolerance_absolute, in length per time)";
    } else {
      text << " (-time_velocity_tolerance, " << options_.velocity_tolerance
           << " of the box's diagonal per time)";
    }
  } else {
    text << "a step in time ends by its energy alone: the velocity tolerance is 0";
  }
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The velocity tolerance is one on directions, for a step of this length.
PetscErrorCode TimeWalk::set_tolerance(double length) {
  PetscFunctionBeginUser;
  if (length == tolerated_length_) PetscFunctionReturn(PETSC_SUCCESS);
  if (tolerated_length_ == 0) PetscCall(say_tolerance());
  tolerated_length_ = length;
  PetscCall(solver_.set_direction_tolerance(tolerated_velocity_ * length));
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

PetscErrorCode TimeWalk::take_step(Attempt *attempt) {
  EnergySums sums;
  PetscFunctionBeginUser;
  PetscCall(set_tolerance(steps_.length()));
  PetscCall(say_step());
  PetscCall(scene_.motion->begin_step(steps_.length(), steps_.next()));
  if (contact_.exists()) {
    PetscCall(contact_.move_to(steps_.next(), &attempt->reason));
    if (!attempt->reason.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(scene_.functional->energy(scene_.displacement, &sums));
  if (!std::isfinite(sums.energy)) {
    attempt->reason = "what is held moves so far that its start has infinite energy";
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(solver_.solve(attempt));
  while (contact_.exists() && attempt->converged) {
    bool again = false;
    PetscCall(contact_.repeats(attempt->iterations, &again));
    if (!again) break;
    record_.add(attempt->record, steps_.accepted() + 1, false);
    PetscCall(solver_.solve(attempt));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Back to the last state that stands. @param goes_on whether a shorter step is left
PetscErrorCode TimeWalk::reject(const Attempt &attempt, bool *goes_on) {
  const double from = steps_.time(), to = steps_.next();
  std::ostringstream text;
  PetscFunctionBeginUser;
  *goes_on = steps_.halve();
  PetscCall(scene_.motion->go_back());
  if (*goes_on) {
    text << "the step to t = " << to << " is halved: " << attempt.reason;
    PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  text << "the step in time from t = " << from << " to " << to << " failed, and -time_step_min "
       << options_.shortest_step() << " allows none of half its length: " << attempt.reason;
  outcome_->failure = text.str();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode TimeWalk::go() {
  bool goes_on = true;
  PetscFunctionBeginUser;
  PetscCall(start());
  while (!steps_.is_done() && goes_on) {
    Attempt attempt;
    PetscCall(take_step(&attempt));
    if (!attempt.record.empty()) outcome_->linear_solver = attempt.linear_solver;
    record_.add(attempt.record, steps_.accepted() + 1, !attempt.converged);
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
    PetscCall(observe_(steps_.time(), attempt.iterations, false));
  }
  outcome_->converged = steps_.is_done();
  outcome_->time = steps_.time();
  outcome_->plugin_record = record_.text();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode walk_in_time(Scene &scene, const StateObserver &observe, SolveOutcome *outcome) {
  PetscFunctionBeginUser;
  PetscCall(TimeWalk(scene, observe, outcome).go());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
