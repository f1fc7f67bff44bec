#pragma once

#include <vector>

#include "output/results_table.hpp"
#include "scene/fields.hpp"
#include "solve/checkpoint.hpp"
#include "solve/solve.hpp"

namespace trefoil {

/// The states of a run, one after the other: what is told of each, in the table of results too, and
/// their fields in the output.
class StateLog {
 public:
  /// @param report gets the states, and has constraints and loads; must outlive this
  StateLog(Scene &scene, RunReport *report);

  /// Takes in the state that the scene is at, see StateObserver. Collective.
  PetscErrorCode observe(double t, PetscInt iterations, bool is_loose);
  /// Describes where the scene is left, and writes it unless that was done. Collective.
  PetscErrorCode close(double t, StateReport *end);

  /// Completes the table of states. Collective.
  PetscErrorCode end_table();
  [[nodiscard]] double seconds() const { return seconds_; }  ///< that it took on this rank

  void save(SavedRun *run) const;
  /// Goes on behind the states of a run that was saved. Collective.
  PetscErrorCode go_on(const Checkpoint &checkpoint);

 private:
  Scene &scene_;
  RunReport &report_;
  std::vector<StateReport> &states_;
  FieldOutput output_;
  ResultsFile table_;
  bool is_written_ = false;  ///< the last state
  double seconds_ = 0;
};

}  // namespace trefoil
