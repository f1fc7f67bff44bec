#pragma once

#include <petscsys.h>

#include <string>

namespace trefoil {

/// Writes text beside `path` and renames: there is never half a file. On the first rank;
/// collective, an error is one on all ranks.
PetscErrorCode write_text_file(MPI_Comm comm, const std::string &path, const std::string &text);
/// Whether `path` can be written; leaves nothing behind. Collective.
PetscErrorCode check_text_file(MPI_Comm comm, const std::string &path);

}  // namespace trefoil
