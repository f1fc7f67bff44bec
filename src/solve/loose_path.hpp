#pragma once

#include <vector>

#include "solve/load_steps.hpp"
#include "solve/run_record.hpp"
#include "solve/scene_solver.hpp"
#include "solve/step_sizes.hpp"

namespace trefoil {

/// Whether so many elements are more than a share of all.
bool is_above(PetscInt64 count, double share, const Scene &scene);

/// A path of loose steps, as it is walked. The scene is left at its end, or, where it has none, at
/// the last state that stands.
class LoosePath {
 public:
  LoosePath(Scene &scene, double begin, Checkpoint &checkpoint, SolveOutcome *outcome)
      : scene_(scene),
        begin_(begin),
        checkpoint_(checkpoint),
        outcome_(outcome),
        comm_(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm))),
        sizes_(StepSizes::adaptive(first_step, least_step)),
        path_(scene) {}

  /// From any displacement.
  /// @param bound the path is given up where its end is nearly reached and not below this energy
  /// @param end how the last solve went; it converged if the path has arrived. A solve that
  /// -snes_max_it has cut short ends the path
  PetscErrorCode go(const StateObserver &observe, double bound, Attempt *end);
  /// Adds where it is to what is saved, and goes on from there. Collective.
  PetscErrorCode save(SavedRun *run) const;
  PetscErrorCode go_on();
  [[nodiscard]] bool has_arrived() const { return sizes_.is_done(); }
  /// Where the last state is that stands.
  [[nodiscard]] double time() const { return sizes_.time(); }
  [[nodiscard]] const std::vector<AttemptRecord> &records() const { return records_; }

 private:
  static constexpr double first_step = 1. / 3, least_step = first_step / 8;

  PetscErrorCode start(double time, Attempt *attempt, bool *is_folded);
  PetscErrorCode solve(double tolerance, Attempt *attempt);
  PetscErrorCode leads_below(double bound, Attempt *attempt, bool *below);
  PetscErrorCode give_up(double time, Attempt *end);
  PetscErrorCode halve(double time, const Attempt &attempt, bool *goes_on);
  void record(const Attempt &attempt, bool is_rejected);

  Scene &scene_;
  double begin_;
  Checkpoint &checkpoint_;
  SolveOutcome *outcome_;
  MPI_Comm comm_;
  StepSizes sizes_;
  LoadPath path_;
  std::vector<AttemptRecord> records_;
  bool has_led_below_ = false;                       ///< its end is nearly reached, and lower
  bool goes_on_ = false, goes_on_in_solve_ = false;  ///< from where it was saved
};

}  // namespace trefoil
