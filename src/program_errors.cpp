#include "program_errors.hpp"

#include <dlfcn.h>
#include <mpi.h>
#include <petscsys.h>
#include <strings.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>

namespace trefoil {
namespace {

std::string kept_sentence;

/// PETSc breaks long sentences into lines.
std::string one_line(const std::string &text) {
  std::string line;
  for (char letter : text) {
    const bool blank = letter == '\n' || letter == '\r' || letter == '\t' || letter == ' ';
    if (!blank) line += letter;
    else if (!line.empty() && line.back() != ' ') line += ' ';
  }
  if (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

void print_kept_error() {
  std::fflush(stdout);
  std::fprintf(stderr, "trefoil: %s\n", one_line(kept_sentence).c_str());
}

/// The last error counts: earlier ones have been recovered from.
PetscErrorCode keep(MPI_Comm, int, const char *, const char *, PetscErrorCode code,
                    PetscErrorType type, const char *message, void *) {
  if (type == PETSC_ERROR_INITIAL) {
    const char *known = nullptr;
    static_cast<void>(PetscErrorMessage(code, &known, nullptr));
    kept_sentence = "PETSc failed with error " + std::to_string(code);
    if (known && *known) kept_sentence += ", " + std::string(known);
    if (message && *message) kept_sentence = message;
  }
  // PETSc's handler of signals aborts all ranks as soon as this returns.
  if (code == PETSC_ERR_SIG) {
    kept_sentence = "a signal ended the run: the program crashed or was told to stop";
    print_kept_error();
  }
  return code;
}

/// PETSc prints errors that come before its own start through this hook as well.
PetscErrorCode print_nothing(const char *, ...) { return static_cast<PetscErrorCode>(0); }

/// On one rank: what keeps PETSc from reading a file of options, or nothing.
std::string problem_of_options_file(const char *file) {
  PetscOptions scratch = nullptr;
  PetscErrorCode error = PetscOptionsCreate(&scratch);
  if (!error) error = PetscOptionsInsertFile(MPI_COMM_SELF, scratch, file, PETSC_TRUE);
  static_cast<void>(PetscOptionsDestroy(&scratch));
  return error ? "cannot read the options file '" + std::string(file) + "': " + kept_sentence +
                     "; check its name, and in a YAML file indentation, brackets and quotes"
               : "";
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

void keep_error(const std::string &sentence) { kept_sentence = sentence; }

bool can_read_options_files(int argc, char **argv) {
  int rank = 0, readable = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  for (int i = 1; rank == 0 && readable && i + 1 < argc; ++i) {
    const bool names_file = strcasecmp(argv[i], "-options_file") == 0 ||
                            strcasecmp(argv[i], "-options_file_yaml") == 0;
    if (!names_file || argv[i + 1][0] == '-') continue;
    const std::string problem = problem_of_options_file(argv[i + 1]);
    readable = problem.empty();
    if (!readable) keep_error(problem);
  }
  MPI_Bcast(&readable, 1, MPI_INT, 0, MPI_COMM_WORLD);
  return readable;
}

void use_one_thread_a_rank() {
  if (std::getenv("OMP_NUM_THREADS") || std::getenv("OPENBLAS_NUM_THREADS")) return;
  // Both libraries have read their environment by now, and CHOLMOD asks OpenMP for threads itself;
  // only calls help. They exist where these libraries do.
  if (auto *set = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
    set(1);
  }
  if (auto *set =
          reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"))) {
    set(0);
  }
}

int finish_ranks(int status) {
  int rank = 0, ranks = 0, first_failed = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  const bool failed = status == 1;
  if (!find_first_failed(failed, &first_failed)) {
    print_kept_error();
    MPI_Abort(MPI_COMM_WORLD, status);
  }
  if (first_failed == rank) print_kept_error();
  if (first_failed < ranks) {
    status = 1;
  } else {
    static_cast<void>(PetscFinalize());
  }
  MPI_Finalize();
  return status;
}

}  // namespace trefoil
