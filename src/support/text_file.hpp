#pragma once

#include <petscsys.h>

#include <string>

namespace trefoil {

/// Where a file will really lie: symbolic links are followed, also one that leads to nothing yet.
/// A rename then replaces the file and leaves the link.
std::string follow_links(const std::string &path);

/// Whether something is there that must be written to and never replaced: a device, a pipe, a
/// socket, or what the program's own output goes to.
bool is_stream(const std::string &path);

/// What the system says where the disk has no room for `bytes` more behind a file, which stays as
/// it is, or where the file cannot be opened; empty where all is well.
std::string find_no_room(const std::string &file, PetscInt64 bytes);

/// Writes text beside `path` and renames: there is never half a file. Devices and pipes are written
/// to, links followed. On the first rank; collective, an error is one on all ranks.
PetscErrorCode write_text_file(MPI_Comm comm, const std::string &path, const std::string &text);
/// Writes text behind what is there, in one piece as far as the system does so; where the disk is
/// full, nothing. On the first rank; collective, an error is one on all ranks.
PetscErrorCode append_text_file(MPI_Comm comm, const std::string &path, const std::string &text);
/// Whether `path` can be written; leaves nothing behind, and removes what dead runs have left of it
/// (see remove_stale_parts()). Collective.
PetscErrorCode check_text_file(MPI_Comm comm, const std::string &path);

}  // namespace trefoil
