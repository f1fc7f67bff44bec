#include "solve/loose_path.hpp"

#include <petsctime.h>

#include <cmath>
#include <sstream>
#include <utility>

#include "solve/saved_numbers.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr double folded_share = 0.01;         // of the elements: inverted where a step starts
constexpr double loose = 0.1, nearly = 1e-3;  // energy tolerances

}  // namespace

bool is_above(PetscInt64 count, double share, const Scene &scene) {
  return static_cast<double>(count) > share * static_cast<double>(scene.mesh.total_cells);
}

void LoosePath::record(const Attempt &attempt, bool is_rejected) {
  if (attempt.record.empty()) return;
  outcome_->linear_solver = attempt.linear_solver;
  records_.push_back({attempt.record, sizes_.accepted() + 1, is_rejected});
}

/// @param is_folded whether a shorter step should be taken instead
PetscErrorCode LoosePath::start(double time, Attempt *attempt, bool *is_folded) {
  PetscInt64 folded = 0;
  std::ostringstream text;
  PetscFunctionBeginUser;
  text << "path to t = " << time << (time < 1 ? ", loosely" : "");
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  PetscCall(path_.follow_to(time, &outcome_->guess));
  PetscCall(scene_.functional->count_inverted(scene_.displacement, &folded));
  *is_folded = !goes_on_in_solve_ && is_above(folded, folded_share, scene_) && sizes_.can_halve();
  if (*is_folded) {
    attempt->reason = std::to_string(folded) + " elements are inverted where it starts";
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoosePath::solve(double tolerance, Attempt *attempt) {
  PetscLogDouble now = 0;
  PetscFunctionBeginUser;
  *attempt = {};
  PetscCall(PetscTime(&now));
  const AttemptOptions how{.head_start = now - begin_,
                           .may_fail = true,
                           .loose_tolerance = tolerance,
                           .goes_on = std::exchange(goes_on_in_solve_, false),
                           .is_last = tolerance == 0};
  PetscCall(solve_from_start(scene_, how, checkpoint_, *outcome_, attempt));
  record(*attempt, !attempt->converged);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves at t = 1 nearly to the end, where what is left is less than what would count.
PetscErrorCode LoosePath::leads_below(double bound, Attempt *attempt, bool *below) {
  EnergySums end;
  PetscFunctionBeginUser;
  PetscCall(solve(nearly, attempt));
  PetscCall(scene_.functional->energy(scene_.displacement, &end));
  *below = attempt->converged && end.energy < bound;
  if (attempt->converged && !*below) {
    PetscCall(PetscPrintf(comm_, "the path leads to no lower energy\n"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where the user has allowed no more iterations: shorter steps would take more.
PetscErrorCode LoosePath::give_up(double time, Attempt *end) {
  std::ostringstream text;
  PetscFunctionBeginUser;
  PetscCall(path_.go_back());
  text << "the path ends at t = " << sizes_.time() << ": the step to t = " << time
       << " takes more iterations than -snes_max_it allows each";
  end->reason = text.str();
  PetscCall(PetscPrintf(comm_, "%s\n", end->reason.c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoosePath::halve(double time, const Attempt &attempt, bool *goes_on) {
  std::ostringstream text;
  PetscFunctionBeginUser;
  PetscCall(path_.go_back());
  *goes_on = sizes_.halve();
  text << "the step to t = " << time << (*goes_on ? " is halved: " : " fails: ") << attempt.reason;
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  if (*goes_on) ++outcome_->path_halvings;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoosePath::save(SavedRun *run) const {
  PetscFunctionBeginUser;
  run->numbers["steps"] = json_of(sizes_.reached());
  run->numbers["path_records"] = json_of(records_);
  run->numbers["path_halvings"] = outcome_->path_halvings;
  run->numbers["has_led_below"] = has_led_below_;
  PetscCall(path_.save(checkpoint_, run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoosePath::go_on() {
  PetscFunctionBeginUser;
  goes_on_ = true;
  PetscCall(checkpoint_.take([&](const Checkpoint::Json &numbers) {
    sizes_.go_on(steps_reached_of(numbers.at("steps")));
    records_ = records_of(numbers.at("path_records"));
    outcome_->path_halvings = numbers.at("path_halvings");
    has_led_below_ = numbers.at("has_led_below");
    goes_on_in_solve_ = numbers.contains("search");
  }));
  PetscCall(path_.go_on(checkpoint_, true, &outcome_->guess));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode LoosePath::go(const StateObserver &observe, double bound, Attempt *end) {
  bool goes_on = true;
  PetscFunctionBeginUser;
  if (!goes_on_) PetscCall(path_.go_back());
  while (!sizes_.is_done() && goes_on) {
    const double time = sizes_.next();
    bool is_folded = false;
    *end = {};
    PetscCall(start(time, end, &is_folded));
    if (time == 1 && !is_folded && std::isfinite(bound) && !has_led_below_) {
      PetscCall(leads_below(bound, end, &has_led_below_));
      if (end->converged && !has_led_below_) break;
      is_folded = !end->converged;
    }
    if (!is_folded) PetscCall(solve(time < 1 ? loose : 0, end));
    if (end->is_cut_short) {
      PetscCall(give_up(time, end));
      break;
    }
    if (!end->converged) {
      has_led_below_ = false;
      PetscCall(halve(time, *end, &goes_on));
      continue;
    }
    PetscCall(path_.accept());
    sizes_.accept(false);
    if (time == 1) continue;
    PetscCall(observe(time, end->iterations, true));
    PetscCall(checkpoint_.pass(true));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
