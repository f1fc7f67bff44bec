#pragma once

#include <petscsnes.h>

#include <string>

#include "scene/scene.hpp"
#include "scene/starting_guess.hpp"

namespace trefoil {

/// What a run found, beside the plugin's own record.
struct SolveOutcome {
  bool converged = false;
  std::string plugin_record;  ///< JSON of the plugin, see TrefoilSNESGetRecord()
  GuessCost guess;
  double energy_rest = 0, energy_scale = 0;
  PetscInt64 inverted_at_start = 0, inverted = 0;
};

/// Minimises the scene's energy from its start with SNES, by default of type trefoil with a direct
/// solver; every -snes_*, -ksp_* and -pc_* of the user wins. Collective. A solve that does not
/// converge is no error: `converged` says so.
PetscErrorCode solve_scene(Scene &scene, SolveOutcome *outcome);

}  // namespace trefoil
