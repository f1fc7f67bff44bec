#include "program/program_errors.hpp"

#include <dlfcn.h>
#include <mpi.h>
#include <petscsys.h>
#include <string.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "support/free_memory.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

std::string kept_sentence;
bool lacked_memory = false;  ///< when it was kept

/// PETSc breaks long sentences into lines.
std::string one_line(const std::string &text) {
  std::string line;
  for (char letter : text) {
    const bool blank = letter == '\n' || letter == '\r' || letter == '\t' || letter == ' ';
    if (!blank) {
      line += letter;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  if (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

void print_kept_error() {
  std::fflush(stdout);
  std::fprintf(stderr, "trefoil: %s\n", one_line(kept_sentence).c_str());
}

/// What libraries fail without in ways of their own: plugins are loaded, buffers are mapped.
constexpr std::size_t least_room = std::size_t{64} << 20;

/// The last error counts: earlier ones have been recovered from.
PetscErrorCode keep(MPI_Comm, int, const char *, const char *, PetscErrorCode code,
                    PetscErrorType type, const char *message, void *) {
  if (type == PETSC_ERROR_INITIAL) {
    const char *known = nullptr;
    static_cast<void>(PetscErrorMessage(code, &known, nullptr));
    kept_sentence = "PETSc failed with error " + std::to_string(code);
    if (known && *known) kept_sentence += ", " + std::string(known);
    if (message && *message) kept_sentence = message;
    lacked_memory = !has_room_for(least_room);
  }
  return code;
}

/// PETSc's own handler says what happened through print_nothing, and aborts all ranks.
PetscErrorCode announce(int signal, void *context) {
  std::fprintf(stderr, "trefoil: stopped by signal %d, %s\n", signal, strsignal(signal));
  return PetscSignalHandlerDefault(signal, context);
}

/// PETSc prints errors that come before its own start through this hook as well.
PetscErrorCode print_nothing(const char *, ...) {
  return static_cast<PetscErrorCode>(0);
}

/// Counts the ranks that are here; the lowest that has failed, or the number of ranks.
/// @return false where a failed rank has waited in vain for the others
bool find_first_failed(bool failed, int *first) {
  constexpr int patience = 1000;  // times 10 ms
  int rank = 0, ranks = 0, arrived = 0;
  MPI_Request all_here = MPI_REQUEST_NULL;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const int mine = failed ? rank : ranks;
  MPI_Iallreduce(&mine, first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD, &all_here);
  MPI_Test(&all_here, &arrived, MPI_STATUS_IGNORE);
  for (int waited = 0; !arrived && !(failed && waited == patience); ++waited) {
    usleep(10000);
    MPI_Test(&all_here, &arrived, MPI_STATUS_IGNORE);
  }
  return arrived;
}

}  // namespace

void keep_errors() {
  PetscErrorPrintf = print_nothing;
  static_cast<void>(PetscPushErrorHandler(keep, nullptr));
}

void leave_signals_alone() {
  static_cast<void>(PetscOptionsSetValue(nullptr, "-no_signal_handler", nullptr));
}

PetscErrorCode announce_signals() {
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsClearValue(nullptr, "-no_signal_handler"));
  PetscCall(PetscPushSignalHandler(announce, nullptr));
  std::signal(SIGPIPE, SIG_DFL);  // who reads no further, `| head`, wants to hear no more
  PetscFunctionReturn(PETSC_SUCCESS);
}

void keep_error(const std::string &sentence) {
  kept_sentence = sentence;
}

bool explain_lack_of_memory(PetscErrorCode error) {
  // CHOLMOD's codes for "out of memory" and "problem too large" reach us in words only.
  const bool of_cholmod = kept_sentence.find("CHOLMOD") != std::string::npos &&
                          (kept_sentence.find("status -2") != std::string::npos ||
                           kept_sentence.find("status -3") != std::string::npos);
  const bool of_factors =
      of_cholmod || kept_sentence.find("memory for the factors") != std::string::npos;
  // Where it has no memory left, PETSc 3.18 gives a line of its source for the code.
  const bool of_petsc =
      error == PETSC_ERR_MEM || error < PETSC_ERR_MIN_VALUE || error > PETSC_ERR_MAX_VALUE;
  if (!error || !(of_petsc || of_cholmod || lacked_memory)) return false;
  kept_sentence = std::string("out of memory") +
                  (of_factors ? " for the factors of the linear solver: -solver iterative needs "
                                "much less; else"
                              : ":") +
                  " use more machines or a coarser mesh (" + kept_sentence + ")";
  return true;
}

void use_one_thread_a_rank() {
  for (const char *name : {"OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"}) {
    const char *wish = std::getenv(name);
    // One thread is what is wanted; but CHOLMOD opens its parallel regions all the same.
    if (wish && std::string(wish) != "1") return;
  }
  // Both libraries have read their environment by now, and CHOLMOD asks OpenMP for threads itself;
  // only calls help. They exist where these libraries do.
  if (auto *set =
          reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
    set(1);
  }
  if (auto *set =
          reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"))) {
    set(0);
  }
}

int finish_ranks(int status, bool has_failed) {
  int rank = 0, ranks = 0, first_failed = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  if (!find_first_failed(has_failed, &first_failed)) {
    print_kept_error();
    MPI_Abort(MPI_COMM_WORLD, status);
  }
  if (first_failed == rank) print_kept_error();
  if (first_failed < ranks) {
    MPI_Bcast(&status, 1, MPI_INT, first_failed, MPI_COMM_WORLD);
  } else {
    PetscBool initialized = PETSC_FALSE;
    static_cast<void>(PetscInitialized(&initialized));
    if (initialized) static_cast<void>(PetscFinalize());
  }
  MPI_Finalize();
  return status;
}

}  // namespace trefoil
