// trefoil: a tetrahedral mesh of an elastic body, held here and moved there, to its equilibrium.
//
//   mpirun -n 2 trefoil examples/knot.yaml -snes_trefoil_record knot.json
//
// Exit status: 0 converged, or help, which solves nothing; 1 bad input, 3 not converged, out of
// memory, or stopped by SIGTERM with a checkpoint.

#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "output/record.hpp"
#include "program/arguments.hpp"
#include "program/help.hpp"
#include "program/manual_page.hpp"
#include "program/program_errors.hpp"
#include "scene/fields.hpp"
#include "scene/scene.hpp"
#include "solve/checkpoint.hpp"
#include "solve/load_steps.hpp"
#include "solve/report.hpp"
#include "solve/scene_check.hpp"
#include "solve/solve.hpp"
#include "solve/solver_help.hpp"
#include "solve/state_log.hpp"
#include "support/free_memory.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"
#include "trefoil.h"

namespace trefoil {
namespace {

constexpr int success = 0, bad_input = 1, not_converged = 3, out_of_memory = 3;

/// Seconds of the slowest rank.
PetscErrorCode share_times(MPI_Comm comm, ProgramTimes *times) {
  double seconds[5] = {times->total, times->read, times->setup, times->output, times->guess};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seconds, 5, MPI_DOUBLE, MPI_MAX, comm));
  *times = {seconds[0], seconds[1], seconds[2], seconds[3], seconds[4]};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The record and the closing words.
PetscErrorCode write_results(MPI_Comm comm, const SceneOptions &options, const RunReport &report) {
  PetscFunctionBeginUser;
  const auto record = make_record(report);
  PetscCheck(record.is_object(), comm, PETSC_ERR_PLIB, "the solver left no record");
  if (!options.record_file.empty()) {
    PetscCall(write_text_file(comm, options.record_file, record.dump(1) + "\n"));
  }
  PetscCall(PetscPrintf(comm, "%s", summary_of(record).c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Solves a scene and writes what it was asked for.
PetscErrorCode solve(MPI_Comm comm, const SceneOptions &options, double begin, int *status) {
  Scene scene;
  SolveOutcome outcome;
  RunReport report;
  StateReport end;
  PetscFunctionBeginUser;
  PetscCall(build_scene(comm, options, &scene));
  PetscCall(choose_load_steps(&scene));
  if (options.check) {
    PetscCall(print_scene_check(scene));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  report.constraints = scene.constraints.reports();
  report.loads = scene.load_reports;
  StateLog log(scene, &report);
  Checkpoint checkpoint(scene);
  PetscCall(checkpoint.open());
  checkpoint.save_results([&](SavedRun *run) {
    log.save(run);
    return PETSC_SUCCESS;
  });
  if (checkpoint.start()) PetscCall(log.go_on(checkpoint));
  const auto observe = [&](double t, PetscInt iterations, bool is_loose) {
    return log.observe(t, iterations, is_loose);
  };
  PetscCall(solve_scene(scene, observe, checkpoint, &outcome));
  PetscCheck(outcome.converged || !outcome.plugin_record.empty(), comm, PETSC_ERR_USER_INPUT,
             "nothing was solved: %s%s", outcome.failure.c_str(),
             outcome.is_hopeless ? ""
                                 : "; shorter steps may get farther, -load_steps auto or, in time, "
                                   "-time_step_min");
  if (!outcome.converged) *status = not_converged;

  PetscCall(scene.progress.pass("solved, results are written"));
  PetscCall(log.close(outcome.time, &end));
  PetscCall(fill_report(scene, outcome, end, &report));
  report.times = {MPI_Wtime() - begin, scene.read_seconds, scene.setup_seconds, log.seconds(),
                  outcome.guess.seconds};
  PetscCall(share_times(comm, &report.times));
  PetscCall(log.end_table());
  PetscCall(write_results(comm, options, report));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode run(const Arguments &arguments, double begin, int *status) {
  const MPI_Comm comm = PETSC_COMM_WORLD;
  SceneOptions options;
  PetscBool asks_for_help = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(TrefoilInitializePackage());
  PetscCall(PetscOptionsHasHelp(nullptr, &asks_for_help));
  if (asks_for_help) {
    PetscCall(print_solver_help(comm));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  options.scene_files = arguments.scene_files;
  PetscCall(read_scene_options(comm, &options));
  if (!options.mesh_write.empty()) {
    PetscCall(write_mesh(comm, options));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(check_outputs(comm, options));
  PetscCall(solve(comm, options, begin, status));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Runs PETSc, and in it the scene. @return the exit status; an error is kept
int run_with_petsc(Arguments &arguments, double begin, bool *has_failed) {
  int status = success;
  int argc = static_cast<int>(arguments.words.size()) + 1;
  char **argv = arguments.argv();
  PetscErrorCode error = PetscInitialize(&argc, &argv, nullptr, scene_help().c_str());
  keep_errors();  // PetscInitialize may have installed its own
  if (!error) error = announce_signals();
  if (!error) error = take_blas_buffer();
  try {
    if (!error) error = run(arguments, begin, &status);
  } catch (const std::bad_alloc &) {
    error = PETSC_ERR_MEM;
    keep_error("there is not enough memory");
  } catch (const std::exception &problem) {
    error = PETSC_ERR_LIB;
    keep_error(std::string("stopped by an unexpected error: ") + problem.what());
  }
  *has_failed = error != PETSC_SUCCESS;
  if (*has_failed) {
    status = explain_lack_of_memory(error) ? out_of_memory
             : was_stopped()               ? not_converged
                                           : bad_input;
  }
  return status;
}

/// Prints on one rank. @return the exit status
int print(const std::string &text, std::FILE *file, int status) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank == 0) std::fputs(text.c_str(), file);
  return status;
}

int run_task(Arguments &arguments, double begin, bool *has_failed) {
  int ranks = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  switch (arguments.task) {
    case Arguments::Task::usage:
      return print(short_help(), stderr, bad_input);
    case Arguments::Task::help:
      return print(short_help(), stdout, success);
    case Arguments::Task::version:
      return print(version_text(ranks), stdout, success);
    case Arguments::Task::keys:
      return print(scene_keys(), stdout, success);
    case Arguments::Task::manual:
      return print(manual_page(), stdout, success);
    case Arguments::Task::run:
      break;
  }
  return run_with_petsc(arguments, begin, has_failed);
}

}  // namespace
}  // namespace trefoil

int main(int argc, char **argv) {
  bool has_failed = false;
  trefoil::Arguments arguments;
  MPI_Init(&argc, &argv);
  const double begin = MPI_Wtime();
  trefoil::use_one_thread_a_rank();
  trefoil::keep_errors();
  trefoil::leave_signals_alone();
  int status = trefoil::bad_input;
  if (trefoil::read_arguments(argc, argv, &arguments)) {
    status = trefoil::run_task(arguments, begin, &has_failed);
  } else {
    has_failed = true;
  }
  return trefoil::finish_ranks(status, has_failed);
}
