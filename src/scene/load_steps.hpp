#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "scene/starting_guess.hpp"

namespace trefoil {

/// The way to a scene's loads and displacements in several steps: the time t of their expressions
/// goes from 1/n to 1, each equilibrium is the start of the next.
class LoadPath {
 public:
  LoadPath(Scene &scene, PetscInt steps) : scene_(scene), steps_(steps) {}
  LoadPath(const LoadPath &) = delete;
  LoadPath &operator=(const LoadPath &) = delete;
  ~LoadPath();

  /// Refuses a path on which nothing depends on t. Collective.
  PetscErrorCode check();

  /// Moves the prescribed vertices and sets the loads for a step, counted from 1. From the second
  /// on the unknowns follow: with a start other than `rest` by the harmonic extension of what the
  /// prescribed vertices have moved since the last step. Collective.
  PetscErrorCode go_to(PetscInt step, GuessCost *cost);

 private:
  PetscErrorCode set_time(double time);
  PetscErrorCode follow(PetscInt step, GuessCost *cost);

  Scene &scene_;
  PetscInt steps_;
  Vec spread_ = nullptr;  ///< harmonic extension of the displacements of the last step
};

/// One record of several solves, one after the other, in the form of each: iterations, solves,
/// trials, saddles and times added up, the histories in a row, whose entries get a `load_step` and
/// whose linear solves go on; `load_step_iterations` lists the iterations of each solve.
std::string join_records(const std::vector<std::string> &records);

}  // namespace trefoil
