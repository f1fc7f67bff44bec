#pragma once

#include "scene/scene.hpp"
#include "solve/checkpoint.hpp"
#include "solve/starting_guess.hpp"

namespace trefoil {

/// The way to a scene's loads and displacements in several steps, the time t of their formulas from
/// 0 to 1: each equilibrium is the start of the next. Where a step fails one can go back to the
/// last that stands.
class LoadPath {
 public:
  explicit LoadPath(Scene &scene) : scene_(scene) {}
  LoadPath(const LoadPath &) = delete;
  LoadPath &operator=(const LoadPath &) = delete;
  ~LoadPath();

  /// Whether anything is prescribed otherwise at one time than at another. Collective.
  PetscErrorCode changes(double first, double last, bool *any);
  /// Refuses a path on which nothing changes between two times. Collective.
  PetscErrorCode check(double first, double last);

  /// Moves the prescribed vertices and sets the loads. Collective.
  PetscErrorCode set_time(double time);

  /// Moves the prescribed vertices and sets the loads. From the second step on the unknowns follow:
  /// with a start other than `rest` by the harmonic extension of what the prescribed vertices have
  /// moved since the last step. Collective.
  PetscErrorCode go_to(double time, GuessCost *cost);

  /// The same also in the first step, whose start is the harmonic extension. Collective.
  PetscErrorCode follow_to(double time, GuessCost *cost);

  /// The scene's displacement stands, as an equilibrium at the time gone to. Collective.
  PetscErrorCode accept();

  /// Back to the last equilibrium that stands; where there is none yet, to the body at rest.
  /// Collective.
  PetscErrorCode go_back();

  /// Adds the last equilibrium that stands, where there is one, to what is saved. Collective.
  PetscErrorCode save(const Checkpoint &checkpoint, SavedRun *run) const;
  /// Goes on from it. Collective.
  /// @param follows whether unknowns will follow, also with start `rest`
  PetscErrorCode go_on(const Checkpoint &checkpoint, bool follows, GuessCost *cost);

  /// Whether an equilibrium stands.
  [[nodiscard]] bool has_stand() const { return stand_ != nullptr; }

 private:
  PetscErrorCode follow(GuessCost *cost);

  Scene &scene_;
  double time_ = 0, time_of_stand_ = 0;
  Vec stand_ = nullptr;  ///< the last equilibrium that stands
  /// Harmonic extensions of the prescribed displacements: at this time, and at that of the stand.
  Vec spread_ = nullptr, spread_of_stand_ = nullptr;
};

/// With contact, the way to where things go has to be free: in steps, unless the user says how
/// many. Collective.
PetscErrorCode choose_load_steps(Scene *scene);

}  // namespace trefoil
