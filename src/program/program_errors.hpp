#pragma once

#include <string>

namespace trefoil {

/// From here on, errors of PETSc and of ours are kept instead of printed with PETSc's stack traces.
/// Works before PetscInitialize.
void keep_errors();

/// From here on, a crash or a signal from outside is one line. Works after PetscInitialize.
void announce_signals();

/// Keeps the sentence of an error that PETSc does not know of.
void keep_error(const std::string &sentence);

/// Looks through the command line and the files of its -options_file on the first rank.
/// PetscInitialize reads the files there too, but most of what can be wrong with one leaves it
/// waiting for ever on the other ranks; here all ranks learn of it. Collective; works before
/// PetscInitialize.
/// @return whether PetscInitialize will be able to read them; otherwise an error is kept
bool can_read_arguments(int argc, char **argv);

/// One thread a rank in BLAS and in OpenMP, unless the user's environment says otherwise: element
/// matrices are too small for more, and ranks would fight for cores.
void use_one_thread_a_rank();

/// Ends MPI. Where `status` is 1 on some rank, the lowest such rank prints the error that it kept,
/// as one line, and 1 is the status of all. Ranks that have failed wait some seconds for the others
/// and then abort them: no rank is left waiting for one that has failed.
int finish_ranks(int status);

}  // namespace trefoil
