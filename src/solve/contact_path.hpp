#pragma once

#include <petscvec.h>

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "solve/checkpoint.hpp"
#include "solve/scene_solver.hpp"

namespace trefoil {

/// What contact asks of who walks from one equilibrium to the next: everything that moves must be
/// free to, and friction lags behind.
class ContactPath {
 public:
  explicit ContactPath(Scene &scene) : scene_(scene) {}
  ContactPath(const ContactPath &) = delete;
  ContactPath &operator=(const ContactPath &) = delete;
  ~ContactPath();

  /// Whether the scene has contact; nothing else may be called where it has none.
  [[nodiscard]] bool exists() const;
  /// Begins at t = 0 with the bodies at rest, or, in time, as they are. Collective. Error: surfaces
  /// intersect there.
  PetscErrorCode begin();
  /// Checks the way from the last equilibrium to the scene's displacement and prescribed values, of
  /// this time. Where unknowns that follow would be in the way they stay where they were, or, where
  /// they are pushed, go where the linearised energy sends them.
  /// @param attempt its reason: one sentence where the way is not free, or nothing; hopeless where
  /// what is prescribed meets by itself
  PetscErrorCode move_to(double time, Attempt *attempt);

  /// Begins a step in time from the last equilibrium, which the scene's displacement is, to the
  /// prescribed values that the scene has now, of this time. Collective.
  PetscErrorCode begin_step(double time);
  /// Goes on to the end of the step. Where the way is not free all that is prescribed, and the
  /// unknowns that it pushes, go the part of it that is: a solve there has to make room before the
  /// next call. Collective.
  /// @param arrived whether it is at the end
  /// @param attempt its reason: one sentence where it comes no farther, or nothing; hopeless as in
  /// move_to()
  PetscErrorCode move_on(bool *arrived, Attempt *attempt);

  /// After a solve: whether friction asks for another one, with its forces of this state.
  /// @param iterations that the solve took
  PetscErrorCode repeats(PetscInt iterations, bool *again);
  /// Takes the scene's displacement as an equilibrium. @param broken one sentence where surfaces
  /// intersect, which the exact test says; it is not taken then
  PetscErrorCode accept(double time, std::string *broken);

  /// Adds the last equilibrium, and where friction lags within a step, to what is saved.
  void save(SavedRun *run) const;
  /// Instead of begin(): goes on from it. Collective.
  PetscErrorCode go_on(const Checkpoint &checkpoint);
  /// Goes on within the step to `time`, whose way has been checked before. Collective.
  PetscErrorCode go_on_in_step(const Checkpoint &checkpoint, double time);

 private:
  /// A state with all that is prescribed.
  struct Place {
    double time = 0;
    std::vector<double> u;   ///< local displacements, held ones too
    Vec unknowns = nullptr;  ///< the same as unknowns
  };

  PetscErrorCode find_way(const Place &from, double time, AllowedMotion *motion);
  PetscErrorCode predict(const Place &from, const std::vector<double> &target, double time,
                         double share);
  PetscErrorCode hold_between(const Place &from, const std::vector<double> &target, double time,
                              double at);
  PetscErrorCode go_part(double share, bool *moved);

  Scene &scene_;
  Place stand_;                 ///< the last equilibrium
  Place part_;                  ///< of a step in time: where the way has led so far
  Place end_;                   ///< and where what is prescribed is to go, without unknowns
  int parts_ = 0;               ///< that the way has taken
  int solves_ = 0;              ///< in this step
  std::vector<double> lagged_;  ///< from where friction has its forces; empty: from stand_
};

}  // namespace trefoil
