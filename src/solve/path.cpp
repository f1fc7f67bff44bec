#include "solve/path.hpp"

#include <petsctime.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "scene/body_materials.hpp"
#include "solve/loose_path.hpp"
#include "solve/path_choice.hpp"
#include "solve/saved_numbers.hpp"
#include "solve/soft_start.hpp"
#include "solve/start.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// A leap, a path, or both.
class Tries {
 public:
  Tries(Scene &scene, const StateObserver &observe, Checkpoint &checkpoint, SolveOutcome *outcome)
      : scene_(scene), observe_(observe), checkpoint_(checkpoint), outcome_(outcome) {}
  Tries(const Tries &) = delete;
  Tries &operator=(const Tries &) = delete;
  ~Tries() {
    static_cast<void>(VecDestroy(&end_of_leap_));
    static_cast<void>(VecDestroy(&end_of_path_));
  }

  PetscErrorCode go();

 private:
  /// What is under way.
  enum class Stage { leap, path, leap_behind_path, leap_beside_path };

  PetscErrorCode save(SavedRun *run) const;
  PetscErrorCode go_on();
  PetscErrorCode begin();
  PetscErrorCode say(const char *what) const {
    return PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm)), "%s\n",
                       what);
  }
  PetscErrorCode soften();
  PetscErrorCode start_leap();
  PetscErrorCode leap(bool may_fail, Attempt *end);
  PetscErrorCode find_bound();
  PetscErrorCode take_path();
  PetscErrorCode return_to_leap();
  [[nodiscard]] bool leap_may_be_lower() const;
  PetscErrorCode leap_beside_path();
  void join();

  Scene &scene_;
  const StateObserver &observe_;
  Checkpoint &checkpoint_;
  SolveOutcome *outcome_;
  Stage stage_ = Stage::leap;
  bool goes_on_ = false;             ///< within what was saved
  std::unique_ptr<LoosePath> path_;  ///< where it is under way
  double bound_ = INFINITY;          ///< the energy of the leap's end, which a path has to beat
  PetscLogDouble begin_ = 0;
  Attempt attempt_;            ///< the one that counts, so far
  Vec end_of_leap_ = nullptr;  ///< null: it was not tried before a path
  Vec end_of_path_ = nullptr;  ///< null: no leap is tried beside it
  bool path_counts_ = false;
  bool has_own_way_ = false;  ///< written in t: where it leads cannot be told from its end
  std::vector<AttemptRecord> leap_records_, path_records_;
};

PetscErrorCode Tries::save(SavedRun *run) const {
  PetscFunctionBeginUser;
  run->numbers["stage"] = static_cast<int>(stage_);
  run->numbers["bound"] = bound_;
  run->numbers["leap"] = json_of(attempt_);
  run->numbers["leap_records"] = json_of(leap_records_);
  run->numbers["path_records"] = json_of(path_records_);
  save_start(*outcome_, run);
  if (path_) PetscCall(path_->save(run));
  if (path_ && end_of_leap_) PetscCall(checkpoint_.keep(end_of_leap_, "end_of_leap", false, run));
  if (end_of_path_) PetscCall(checkpoint_.keep(end_of_path_, "end_of_path", false, run));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Tries::go_on() {
  PetscFunctionBeginUser;
  PetscCall(checkpoint_.take([&](const Checkpoint::Json &numbers) {
    stage_ = static_cast<Stage>(numbers.at("stage").get<int>());
    goes_on_ = stage_ == Stage::path || numbers.contains("search");
    bound_ = numbers.at("bound").is_null() ? INFINITY : numbers.at("bound").get<double>();
    attempt_ = attempt_of(numbers.at("leap"));
    leap_records_ = records_of(numbers.at("leap_records"));
    path_records_ = records_of(numbers.at("path_records"));
  }));
  path_counts_ = stage_ == Stage::leap_beside_path;
  outcome_->path_is_rejected = stage_ == Stage::leap_behind_path;
  PetscCall(load_start(checkpoint_, outcome_));
  if (stage_ == Stage::leap_beside_path) {
    PetscCall(VecDuplicate(scene_.displacement, &end_of_path_));
    PetscCall(checkpoint_.fetch("end_of_path", end_of_path_));
  }
  if (!std::isfinite(bound_)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(scene_.displacement, &end_of_leap_));
  PetscCall(checkpoint_.fetch("end_of_leap", end_of_leap_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Nearer to the end, where that is worth a solve.
PetscErrorCode Tries::soften() {
  PetscLogDouble now = 0;
  PetscFunctionBeginUser;
  if (!softens_start(scene_)) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscTime(&now));
  PetscCall(soften_start(scene_, now - begin_, checkpoint_, outcome_, &leap_records_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Back to where a leap starts, from a path.
PetscErrorCode Tries::start_leap() {
  PetscFunctionBeginUser;
  PetscCall(LoadPath(scene_).set_time(1));
  PetscCall(VecSet(scene_.displacement, 0));
  PetscCall(make_start(scene_, outcome_));
  PetscCall(soften());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Tries::leap(bool may_fail, Attempt *end) {
  PetscLogDouble now = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscTime(&now));
  const AttemptOptions how{.head_start = now - begin_,
                           .may_fail = may_fail,
                           .goes_on = std::exchange(goes_on_, false),
                           .is_last = true};
  PetscCall(solve_from_start(scene_, how, checkpoint_, *outcome_, end));
  if (end->record.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  outcome_->linear_solver = end->linear_solver;
  leap_records_.push_back({end->record, 1, false});
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// To the end of the leap, which is taken now if it was not.
PetscErrorCode Tries::return_to_leap() {
  PetscFunctionBeginUser;
  if (end_of_leap_) {
    PetscCall(LoadPath(scene_).set_time(1));
    PetscCall(VecCopy(end_of_leap_, scene_.displacement));
    PetscCall(say("the end of the leap, which came first, counts"));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(say(has_own_way_ ? "no path: a leap instead, which follows nothing that is written in t"
                             : "no path: a leap instead, whose end counts"));
  stage_ = Stage::leap_behind_path;
  PetscCall(start_leap());
  PetscCall(leap(false, &attempt_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A path that was taken at once and has ended with inverted elements: where volume is cheap, a
/// leap from fitted rotations may end lower. Where it is dear it takes long, and does not.
bool Tries::leap_may_be_lower() const {
  return path_counts_ && attempt_.converged && attempt_.inverted > 0 && !end_of_leap_ &&
         !has_own_way_ && !is_nearly_incompressible(scene_.options);
}

PetscErrorCode Tries::leap_beside_path() {
  Attempt leap_end;
  constexpr double same_end = 1e-8;  // as solves end, in units of the energy's scale
  EnergySums of_path, of_leap;
  PetscFunctionBeginUser;
  if (!end_of_path_) {
    stage_ = Stage::leap_beside_path;
    PetscCall(VecDuplicate(scene_.displacement, &end_of_path_));
    PetscCall(VecCopy(scene_.displacement, end_of_path_));
    PetscCall(say("the path ends with inverted elements: a leap, too"));
    PetscCall(start_leap());
  }
  PetscCall(leap(true, &leap_end));
  PetscCall(scene_.functional->energy(end_of_path_, &of_path));
  PetscCall(scene_.functional->energy(scene_.displacement, &of_leap));
  if (leap_end.converged && of_leap.energy < of_path.energy - same_end * of_path.scale) {
    attempt_ = leap_end;
    path_counts_ = false;
    outcome_->path_is_rejected = true;
    outcome_->path_halvings = 0;
    PetscCall(say("the leap ends below the path, which came first: it counts"));
  } else {
    PetscCall(say("the end of the path, which came first, counts"));
    PetscCall(VecCopy(end_of_path_, scene_.displacement));
    outcome_->linear_solver = attempt_.linear_solver;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Of a leap that was taken.
PetscErrorCode Tries::find_bound() {
  EnergySums of_leap;
  PetscFunctionBeginUser;
  if (leap_records_.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(VecDuplicate(scene_.displacement, &end_of_leap_));
  PetscCall(VecCopy(scene_.displacement, end_of_leap_));
  PetscCall(scene_.functional->energy(end_of_leap_, &of_leap));
  bound_ = of_leap.energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Tries::take_path() {
  Attempt end;
  PetscFunctionBeginUser;
  stage_ = Stage::path;
  path_ = std::make_unique<LoosePath>(scene_, begin_, checkpoint_, outcome_);
  if (std::exchange(goes_on_, false)) {
    PetscCall(path_->go_on());
  } else {
    PetscCall(find_bound());
    if (end_of_leap_) PetscCall(say("the leap ends with inverted elements: a path, too"));
  }
  PetscCall(path_->go(observe_, bound_, &end));
  path_records_ = path_->records();
  const bool is_cut_short = end.is_cut_short && !end_of_leap_;
  path_counts_ = path_->has_arrived() || is_cut_short;
  if (is_cut_short) {
    outcome_->time = path_->time();
    outcome_->failure = end.reason;
  }
  path_.reset();
  if (path_counts_) {
    if (end_of_leap_) PetscCall(say("the path ends below the leap, which came first: it counts"));
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
  run.add(path_counts_ ? leap_records_ : path_records_, false);
  run.add(path_counts_ ? path_records_ : leap_records_, true);
  outcome_->plugin_record = run.text();
}

/// At the start of a leap, or, where the scene is hard or has a way of its own, before a path.
PetscErrorCode Tries::begin() {
  PetscFunctionBeginUser;
  PetscCall(has_own_way_ ? say("what is written in t goes a way of its own: it is followed")
                         : make_start(scene_, outcome_));
  if (has_own_way_ || is_hard(outcome_->inverted_at_start, scene_)) {
    stage_ = Stage::path;
  } else {
    PetscCall(soften());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Tries::go() {
  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin_));
  PetscCall(goes_own_way(scene_, &has_own_way_));
  checkpoint_.save_way([this](SavedRun *run) { return save(run); });
  if (checkpoint_.start()) {
    PetscCall(go_on());
    if (!goes_on_) {  // a leap that was stopped while its start was made
      leap_records_.clear();
      PetscCall(start_leap());
      checkpoint_.end_start();
    }
  } else {
    PetscCall(begin());
  }
  if (stage_ == Stage::leap || stage_ == Stage::leap_behind_path) {
    PetscCall(leap(false, &attempt_));
  }
  const bool is_folded = stage_ == Stage::leap && attempt_.converged && attempt_.inverted > 0;
  if (stage_ == Stage::path || is_folded) PetscCall(take_path());
  if (stage_ == Stage::leap_beside_path || leap_may_be_lower()) PetscCall(leap_beside_path());
  outcome_->converged = attempt_.converged;
  if (attempt_.converged) PetscCall(observe_(1, attempt_.iterations, false));
  join();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode solve_by_leap_or_path(Scene &scene, const StateObserver &observe,
                                     Checkpoint &checkpoint, SolveOutcome *outcome) {
  PetscFunctionBeginUser;
  PetscCall(Tries(scene, observe, checkpoint, outcome).go());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
