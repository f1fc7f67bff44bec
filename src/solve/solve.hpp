#pragma once

#include <petscsnes.h>

#include <functional>
#include <string>

#include "output/run_report.hpp"
#include "scene/scene.hpp"
#include "solve/checkpoint.hpp"
#include "solve/linear_solver.hpp"
#include "solve/starting_guess.hpp"

namespace trefoil {

/// What a run found, beside the plugin's own record.
struct SolveOutcome {
  bool converged = false;
  /// Where the way in load steps ended before t = 1, and why; empty: it did not.
  std::string failure;
  bool is_hopeless = false;       ///< shorter steps would end there as well
  double time = 1;                ///< t of the state that the scene is left at
  int path_halvings = 0;          ///< of steps on a path of the program's own accord
  bool path_is_rejected = false;  ///< such a path was walked, and the end of a leap counts
  std::string plugin_record;      ///< JSON of the plugin, see TrefoilSNESGetRecord()
  std::string linear_solver;      ///< in words, see LinearSolver
  GuessCost guess;
  double energy_rest = 0, energy_scale = 0;
  PetscInt64 inverted_at_start = 0, inverted = 0;
};

/// What is done with each state that stands, where the scene is at it: at time t, after so many
/// iterations. A loose one, on a path of the program's own accord, is no equilibrium.
using StateObserver = std::function<PetscErrorCode(double t, PetscInt iterations, bool is_loose)>;

/// Minimises the scene's energy from its start with SNES, by default of type trefoil with a direct
/// solver; every -snes_*, -ksp_* and -pc_* of the user wins. In load steps each equilibrium is the
/// start of the next; `auto` ones are halved where a step fails or turns elements round, and grow
/// again. Collective. A solve that does not converge is no error: `converged` says so, and the
/// scene is left at the last equilibrium that stands (where there was but one solve, at its last
/// iterate). A hard scene, see solve_by_leap_or_path(), is led to its end on a path of a few loose
/// steps.
/// @param checkpoint where the run is saved on its way, and what it goes on from; open
PetscErrorCode solve_scene(Scene &scene, const StateObserver &observe, Checkpoint &checkpoint,
                           SolveOutcome *outcome);

/// What would solve the scene's linear systems, with the size of a factor. Solves nothing; options
/// that no solver knows are errors where they can be told without. Collective.
PetscErrorCode expect_linear_solver(Scene &scene, LinearSolver *solver);

}  // namespace trefoil
