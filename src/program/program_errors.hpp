#pragma once

#include <petscsys.h>

#include <string>

namespace trefoil {

/// From here on, errors of PETSc and of ours are kept instead of printed with PETSc's stack traces.
/// Works before PetscInitialize.
void keep_errors();

/// Lets PetscInitialize install no handler of signals: its own would not know of broken pipes.
void leave_signals_alone();

/// From here on, a crash or a signal from outside is one line. Works after PetscInitialize.
PetscErrorCode announce_signals();

/// Keeps the sentence of an error that PETSc does not know of.
void keep_error(const std::string &sentence);

/// Whether that error is a lack of memory; then its sentence becomes one that says so, and what
/// helps.
bool explain_lack_of_memory(PetscErrorCode error);

/// One thread a rank in BLAS and in OpenMP, unless the user's environment says otherwise: element
/// matrices are too small for more, and ranks would fight for cores.
void use_one_thread_a_rank();

/// Ends PETSc, where it runs, and MPI. Where some rank has failed, the lowest such rank prints the
/// error that it kept, as one line, and its status is that of all. Ranks that have failed wait some
/// seconds for the others and then abort them: no rank is left waiting for one that has failed.
int finish_ranks(int status, bool has_failed);

}  // namespace trefoil
