#pragma once

#include <string>

namespace trefoil {

/// From here on, errors of PETSc and of ours are kept instead of printed with PETSc's stack traces.
/// Works before PetscInitialize.
void keep_errors();

/// The first error's sentence; empty where there was none.
std::string kept_error();

/// One thread a rank in BLAS and in OpenMP, unless the user's environment says otherwise: element
/// matrices are too small for more, and ranks would fight for cores.
void use_one_thread_a_rank();

/// Ends MPI in order if all ranks come here within some seconds, with an abort otherwise: no rank
/// is left waiting for one that has failed. Returns `status`.
int finish_ranks(int status);

}  // namespace trefoil
