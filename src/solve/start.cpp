#include "solve/start.hpp"

#include <nlohmann/json.hpp>

#include "scene/initial_displacement.hpp"
#include "solve/starting_guess.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode make_start(Scene &scene, SolveOutcome *outcome) {
  const std::string initial = choose_initial(scene.options);
  PetscFunctionBeginUser;
  if (initial == "expression") {
    PetscCall(set_initial_displacement(scene.options.initial_displacement, scene.discretization,
                                       scene.displacement));
  } else if (initial == "file") {
    std::vector<double> displacement;
    PetscCall(
        CheckpointFiles(scene.mesh).read_displacement(scene.options.initial_file, &displacement));
    PetscCall(set_unknowns(std::move(displacement), scene.discretization, scene.displacement));
  } else if (initial != "rest") {
    PetscCall(spread_displacements(*scene.functional, scene.discretization, scene.matrix_of_cells(),
                                   initial == "arap" ? scene.options.initial_steps : 0,
                                   scene.linear_solver.kind != SolverKind::direct, scene.progress,
                                   scene.displacement, &outcome->guess));
  }
  PetscCall(scene.functional->count_inverted(scene.displacement, &outcome->inverted_at_start));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void save_start(const SolveOutcome &outcome, SavedRun *run) {
  run->numbers["start"] = {{"linear_solves", outcome.guess.linear_solves},
                           {"rotations", outcome.guess.rotations},
                           {"inverted", outcome.inverted_at_start}};
}

PetscErrorCode load_start(const Checkpoint &checkpoint, SolveOutcome *outcome) {
  PetscFunctionBeginUser;
  PetscCall(checkpoint.take([&](const Checkpoint::Json &numbers) {
    const auto &start = numbers.at("start");
    outcome->guess.linear_solves = start.at("linear_solves");
    outcome->guess.rotations = start.at("rotations");
    outcome->inverted_at_start = start.at("inverted");
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
