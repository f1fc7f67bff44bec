#include "solve/path.hpp"

#include <petsctime.h>

#include <cmath>
#include <sstream>
#include <vector>

#include "solve/load_steps.hpp"
#include "solve/run_record.hpp"
#include "solve/scene_solver.hpp"
#include "solve/step_sizes.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr double first_step = 1. / 3, least_step = first_step / 8;
constexpr double hard_share = 0.005;          // of the elements: inverted by the guess of a leap
constexpr double folded_share = 0.01;         // the same where a step starts
constexpr double loose = 0.1, nearly = 1e-3;  // energy tolerances

/// One solve, as the plugin recorded it.
struct SolveRecord {
  std::string json;
  int load_step = 1;
  bool is_rejected = false;
};

bool is_above(PetscInt64 count, double share, const Scene &scene) {
  return static_cast<double>(count) > share * static_cast<double>(scene.mesh.total_cells);
}

/// A path of loose steps, as it is walked. The scene is left at its end, or, where it has none, at
/// the last state that stands.
class Path {
 public:
  Path(Scene &scene, double begin, SolveOutcome *outcome)
      : scene_(scene),
        begin_(begin),
        outcome_(outcome),
        comm_(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))),
        sizes_(StepSizes::adaptive(first_step, least_step)),
        path_(scene) {}

  /// From any displacement.
  /// @param bound the path is given up where its end is nearly reached and not below this energy
  /// @param end how the last solve went; it converged if the path has arrived
  PetscErrorCode go(const StateObserver &observe, double bound, Attempt *end);
  [[nodiscard]] bool has_arrived() const { return sizes_.is_done(); }
  [[nodiscard]] const std::vector<SolveRecord> &records() const { return records_; }

 private:
  PetscErrorCode start(double time, Attempt *attempt, bool *is_folded);
  PetscErrorCode solve(double tolerance, Attempt *attempt);
  PetscErrorCode leads_below(double bound, Attempt *attempt, bool *below);
  PetscErrorCode halve(double time, const Attempt &attempt, bool *goes_on);
  void record(const Attempt &attempt, bool is_rejected);

  Scene &scene_;
  double begin_;
  SolveOutcome *outcome_;
  MPI_Comm comm_;
  StepSizes sizes_;
  LoadPath path_;
  std::vector<SolveRecord> records_;
};

void Path::record(const Attempt &attempt, bool is_rejected) {
  if (attempt.record.empty()) return;
  outcome_->linear_solver = attempt.linear_solver;
  records_.push_back({attempt.record, sizes_.accepted() + 1, is_rejected});
}

/// @param is_folded whether a shorter step should be taken instead
PetscErrorCode Path::start(double time, Attempt *attempt, bool *is_folded) {
  PetscInt64 folded = 0;
  std::ostringstream text;
  PetscFunctionBeginUser;
  text << "path to t = " << time << (time < 1 ? ", loosely" : "");
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  PetscCall(path_.follow_to(time, &outcome_->guess));
  PetscCall(scene_.functional->count_inverted(scene_.displacement, &folded));
  *is_folded = is_above(folded, folded_share, scene_) && sizes_.can_halve();
  if (*is_folded) {
    attempt->reason = std::to_string(folded) + " elements are inverted where it starts";
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Path::solve(double tolerance, Attempt *attempt) {
  PetscLogDouble now = 0;
  PetscFunctionBeginUser;
  *attempt = {};
  PetscCall(PetscTime(&now));
  PetscCall(solve_from_start(scene_, {now - begin_, true, tolerance}, *outcome_, attempt));
  record(*attempt, !attempt->converged);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves at t = 1 nearly to the end, where what is left is less than what would count.
PetscErrorCode Path::leads_below(double bound, Attempt *attempt, bool *below) {
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

PetscErrorCode Path::halve(double time, const Attempt &attempt, bool *goes_on) {
  std::ostringstream text;
  PetscFunctionBeginUser;
  PetscCall(path_.go_back());
  *goes_on = sizes_.halve();
  text << "the step to t = " << time << (*goes_on ? " is halved: " : " fails: ") << attempt.reason;
  PetscCall(PetscPrintf(comm_, "%s\n", text.str().c_str()));
  if (*goes_on) ++outcome_->path_halvings;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Path::go(const StateObserver &observe, double bound, Attempt *end) {
  bool goes_on = true;
  PetscFunctionBeginUser;
  PetscCall(path_.go_back());
  while (!sizes_.is_done() && goes_on) {
    const double time = sizes_.next();
    bool is_folded = false;
    *end = {};
    PetscCall(start(time, end, &is_folded));
    if (time == 1 && !is_folded && std::isfinite(bound)) {
      PetscCall(leads_below(bound, end, &goes_on));
      if (end->converged && !goes_on) break;
      goes_on = true;
      is_folded = !end->converged;
    }
    if (!is_folded) PetscCall(solve(time < 1 ? loose : 0, end));
    if (!end->converged) {
      PetscCall(halve(time, *end, &goes_on));
      continue;
    }
    PetscCall(path_.accept());
    sizes_.accept(false);
    if (time < 1) PetscCall(observe(time, end->iterations, true));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A leap, a path, or both.
class Tries {
 public:
  Tries(Scene &scene, const StateObserver &observe, SolveOutcome *outcome)
      : scene_(scene), observe_(observe), outcome_(outcome) {}
  Tries(const Tries &) = delete;
  Tries &operator=(const Tries &) = delete;
  ~Tries() { static_cast<void>(VecDestroy(&end_of_leap_)); }

  PetscErrorCode go();

 private:
  PetscErrorCode leap();
  PetscErrorCode take_path();
  PetscErrorCode return_to_leap();
  void join();

  Scene &scene_;
  const StateObserver &observe_;
  SolveOutcome *outcome_;
  PetscLogDouble begin_ = 0;
  Attempt attempt_;            ///< the one that counts, so far
  Vec end_of_leap_ = nullptr;  ///< null: it was not tried
  bool path_counts_ = false;
  std::vector<SolveRecord> leap_records_, path_records_;
};

PetscErrorCode Tries::leap() {
  PetscLogDouble now = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  PetscCall(solve_from_start(scene_, {now - begin_}, *outcome_, &attempt_));
  outcome_->linear_solver = attempt_.linear_solver;
  leap_records_.push_back({attempt_.record, 1, false});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// To the end of the leap, which is taken now if it was not.
PetscErrorCode Tries::return_to_leap() {
  PetscFunctionBeginUser;
  PetscCall(LoadPath(scene_).set_time(1));
  if (end_of_leap_) {
    PetscCall(VecCopy(end_of_leap_, scene_.displacement));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(VecSet(scene_.displacement, 0));
  PetscCall(make_start(scene_, outcome_));
  PetscCall(leap());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Tries::take_path() {
  Path path(scene_, begin_, outcome_);
  double bound = INFINITY;
  Attempt end;
  PetscFunctionBeginUser;
  if (!leap_records_.empty()) {
    EnergySums of_leap;
    PetscCall(VecDuplicate(scene_.displacement, &end_of_leap_));
    PetscCall(VecCopy(scene_.displacement, end_of_leap_));
    PetscCall(scene_.functional->energy(end_of_leap_, &of_leap));
    bound = of_leap.energy;
  }
  PetscCall(path.go(observe_, bound, &end));
  path_records_ = path.records();
  path_counts_ = path.has_arrived();
  if (path_counts_) {
    attempt_ = end;
  } else {
    outcome_->path_is_rejected = true;
    if (end.converged) outcome_->path_halvings = 0;  // it led elsewhere
    PetscCall(return_to_leap());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// One record, in which what counts comes last.
void Tries::join() {
  RunRecord run("load_step");
  const auto add = [&](const std::vector<SolveRecord> &records, bool counts) {
    for (const SolveRecord &record : records) {
      run.add(record.json, record.load_step, record.is_rejected || !counts);
    }
  };
  add(path_counts_ ? leap_records_ : path_records_, false);
  add(path_counts_ ? path_records_ : leap_records_, true);
  outcome_->plugin_record = run.text();
}

PetscErrorCode Tries::go() {
  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin_));
  PetscCall(make_start(scene_, outcome_));
  const bool is_hard = is_above(outcome_->inverted_at_start, hard_share, scene_);
  if (!is_hard) PetscCall(leap());
  if (is_hard || (attempt_.converged && attempt_.inverted > 0)) PetscCall(take_path());
  outcome_->converged = attempt_.converged;
  if (attempt_.converged) PetscCall(observe_(1, attempt_.iterations, false));
  join();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode may_take_path(const SceneOptions &options, bool *may) {
  PetscFunctionBeginUser;
  *may = options.initial == "auto";
  for (const char *option : {"-load_steps", "-snes_type"}) {
    PetscBool is_given = PETSC_FALSE;
    PetscCall(PetscOptionsHasName(nullptr, nullptr, option, &is_given));
    *may = *may && !is_given;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode solve_by_leap_or_path(Scene &scene, const StateObserver &observe,
                                     SolveOutcome *outcome) {
  PetscFunctionBeginUser;
  PetscCall(Tries(scene, observe, outcome).go());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
