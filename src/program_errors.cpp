#include "program_errors.hpp"

#include <dlfcn.h>
#include <mpi.h>
#include <petscsys.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdlib>

namespace trefoil {
namespace {

std::string first_sentence;

PetscErrorCode keep(MPI_Comm, int, const char *, const char *, PetscErrorCode code,
                    PetscErrorType type, const char *message, void *) {
  if (type == PETSC_ERROR_INITIAL && first_sentence.empty()) {
    first_sentence = message && *message ? message : "PETSc failed with error " + std::to_string(code);
  }
  return code;
}

/// PETSc prints errors that come before its own start through this hook as well.
PetscErrorCode print_nothing(const char *, ...) { return static_cast<PetscErrorCode>(0); }

}  // namespace

void keep_errors() {
  PetscErrorPrintf = print_nothing;
  static_cast<void>(PetscPushErrorHandler(keep, nullptr));
}

std::string kept_error() { return first_sentence; }

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
  constexpr int patience = 1000;  // times 10 ms
  MPI_Request all_here = MPI_REQUEST_NULL;
  int here = 0;
  MPI_Ibarrier(MPI_COMM_WORLD, &all_here);
  for (int waited = 0; !here && waited < patience; ++waited) {
    MPI_Test(&all_here, &here, MPI_STATUS_IGNORE);
    if (!here) usleep(10000);
  }
  if (!here) MPI_Abort(MPI_COMM_WORLD, status);
  PetscBool initialized = PETSC_FALSE;
  static_cast<void>(PetscInitialized(&initialized));
  if (initialized && status != 1) static_cast<void>(PetscFinalize());
  MPI_Finalize();
  return status;
}

}  // namespace trefoil
