// trefoil: a tetrahedral mesh of an elastic body, held here and moved there, to its equilibrium.
//
//   mpirun -n 2 trefoil -options_file examples/knot.yaml -snes_trefoil_record knot.json
//
// Exit status: 0 converged, or -help, which solves nothing; 1 bad input, 3 not converged.

#include <petsctime.h>

#include <exception>
#include <string>

#include "output/result.hpp"
#include "program/program_errors.hpp"
#include "scene/option_reader.hpp"
#include "scene/scene.hpp"
#include "scene/solve.hpp"
#include "scene/solver_help.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"
#include "trefoil.h"

static const char help[] =
    "Finds the equilibrium of an elastic body: a mesh, a material, what is held and what is "
    "moved.\n"
    "Options come from a YAML file, -options_file scene.yaml, or from the command line; what "
    "comes\n"
    "later wins.\n\n";

static PetscErrorCode run(double begin, bool *converged) {
  using namespace trefoil;
  const MPI_Comm comm = PETSC_COMM_WORLD;
  SceneOptions options;
  Scene scene;
  SolveOutcome outcome;
  ProgramTimes times;
  PetscLogDouble solved = 0, written = 0;
  std::string record;
  PetscBool asks_for_help = PETSC_FALSE;

  PetscFunctionBeginUser;
  PetscCall(TrefoilInitializePackage());
  PetscCall(read_scene_options(comm, &options));
  PetscCall(PetscOptionsHasHelp(nullptr, &asks_for_help));
  if (asks_for_help) {
    PetscCall(print_solver_help(comm));
    *converged = true;
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(check_outputs(comm, options));
  PetscCall(build_scene(comm, options, &scene));
  PetscCall(solve_scene(scene, &outcome));
  *converged = outcome.converged;

  PetscCall(PetscTime(&solved));
  PetscCall(write_fields(scene));
  PetscCall(PetscTime(&written));
  times.read = scene.read_seconds;
  times.setup = scene.setup_seconds;
  times.output = written - solved;
  times.total = MPI_Wtime() - begin;
  PetscCall(complete_record(scene, outcome, times, &record));
  if (!options.record_file.empty()) {
    PetscCall(write_text_file(comm, options.record_file, record + "\n"));
  }
  PetscCall(print_summary(comm, record));
  PetscCall(print_unused_options(comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

int main(int argc, char **argv) {
  constexpr int bad_input = 1, not_converged = 3;
  bool converged = false;
  MPI_Init(&argc, &argv);
  const double begin = MPI_Wtime();
  trefoil::use_one_thread_a_rank();
  trefoil::keep_errors();
  if (!trefoil::can_read_arguments(argc, argv)) return trefoil::finish_ranks(bad_input);
  PetscErrorCode error = PetscInitialize(&argc, &argv, nullptr, help);
  if (error) return trefoil::finish_ranks(bad_input);
  trefoil::keep_errors();  // PetscInitialize may have installed its own
  trefoil::announce_signals();
  try {
    error = run(begin, &converged);
  } catch (const std::exception &problem) {
    trefoil::keep_error(std::string("stopped by an unexpected error: ") + problem.what());
    return trefoil::finish_ranks(bad_input);
  }
  if (error) return trefoil::finish_ranks(bad_input);
  return trefoil::finish_ranks(converged ? 0 : not_converged);
}
