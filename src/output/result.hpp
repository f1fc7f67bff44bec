#pragma once

#include <string>

#include "scene/scene.hpp"
#include "scene/solve.hpp"

namespace trefoil {

/// Asks whether the files that the options name can be written, before a long solve. Collective.
PetscErrorCode check_outputs(MPI_Comm comm, const SceneOptions &options);

/// Writes displacement and, for each cell, det F, energy density, number of negative eigenvalues
/// and rank, where the options name an output file. Collective.
PetscErrorCode write_fields(const Scene &scene);

/// Seconds of the program outside the solve; the rest of `total` is the solve's.
struct ProgramTimes {
  double total = 0, read = 0, setup = 0, output = 0, guess = 0;
};

/// The plugin's record completed by mesh, energies and times of the whole program, as JSON.
/// Collective.
PetscErrorCode complete_record(const Scene &scene, const SolveOutcome &outcome,
                               const ProgramTimes &times, std::string *json);

/// The closing words: converged or why not, iterations, energy, time by phase. Collective.
PetscErrorCode print_summary(MPI_Comm comm, const std::string &record);

}  // namespace trefoil
