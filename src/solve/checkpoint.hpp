#pragma once

#include <functional>
#include <string>

#include "output/checkpoint_file.hpp"
#include "scene/scene.hpp"

namespace trefoil {

/// What a run saves on its way, so that another can go on from there, and what it goes on from
/// itself: -checkpoint, -restart. Parts of the program add to a checkpoint what they know. Without
/// these options nothing is done.
class Checkpoint {
 public:
  using Json = nlohmann::ordered_json;
  /// Adds to what is saved. Collective.
  using Part = std::function<PetscErrorCode(SavedRun *)>;

  explicit Checkpoint(Scene &scene);
  Checkpoint(const Checkpoint &) = delete;
  Checkpoint &operator=(const Checkpoint &) = delete;
  ~Checkpoint();

  /// Reads what -restart names, and listens for SIGTERM and SIGUSR1 where checkpoints are written.
  /// Collective. Errors, one sentence on all ranks: see CheckpointFiles::read().
  PetscErrorCode open();

  /// What is always saved: of the run's results, and of its way from state to state.
  void save_results(Part part) { results_ = std::move(part); }
  void save_way(Part part) { way_ = std::move(part); }

  /// A moment at which the run can be saved. All ranks agree on whether it is, and whether it ends
  /// here: PETSC_ERR_SIG with a sentence after SIGTERM. Collective.
  /// @param counts for -checkpoint_every and -checkpoint_seconds; other moments are for signals
  /// @param solve what a solve that is under way adds, or nothing
  PetscErrorCode pass(bool counts, const Part &solve = {});
  /// Saves the run. Collective; a file that cannot be written is a warning.
  PetscErrorCode save(const Part &solve = {});

  [[nodiscard]] bool is_on() const;
  /// What the run goes on from; null: it begins. Parts take it in by take().
  [[nodiscard]] const SavedRun *start() const { return start_ ? &*start_ : nullptr; }
  /// Reads numbers of what the run goes on from. What does not fit is an error with one sentence.
  PetscErrorCode take(const std::function<void(const Json &numbers)> &read) const;
  /// Nothing is taken in any more.
  void end_start() { start_.reset(); }

  /// Adds unknowns, or a change of them, to what is saved. Collective.
  PetscErrorCode keep(Vec x, const std::string &name, bool is_change, SavedRun *run) const;
  /// The other way round.
  PetscErrorCode fetch(const std::string &name, Vec x) const;
  /// A field of what the run goes on from. An error where there is none.
  PetscErrorCode fetch(const std::string &name, std::vector<double> *values) const;

 private:
  PetscErrorCode check_kind() const;
  PetscErrorCode warn_of_changes();
  PetscErrorCode wish(bool counts, int *wish);
  [[nodiscard]] MPI_Comm comm() const;

  Scene &scene_;
  CheckpointFiles files_;
  Part results_, way_;
  [[nodiscard]] std::string changes_of_way() const;

  std::optional<SavedRun> start_;
  PetscInt passes_ = 0;
  double last_ = 0;  ///< when the last one was written, by the first rank's clock
  bool listens_ = false, has_failed_ = false;  ///< has_failed: the last one
};

/// Whether SIGTERM has ended the run.
bool was_stopped();

}  // namespace trefoil
