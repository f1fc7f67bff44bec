#pragma once

#include <petscsys.h>

#include <string>

namespace trefoil {

/// Bytes that the processes of this machine may still take together: what the kernel calls
/// available (/proc/meminfo), and no more than what any control group of this process, or one above
/// it, has left (both versions of cgroup; pages of files that it would give up count as free).
/// Infinite where nothing is known.
/// @param root the folder that proc and sys are in, for tests
double free_bytes_of_machine(const std::string &root = "/");

/// Bytes that this process may still take by its own limit, `ulimit -v`; infinite without one.
double free_bytes_of_process(const std::string &root = "/");

/// Whether this process gets that many bytes in one piece now.
bool has_room_for(std::size_t bytes);

/// Lets OpenBLAS, where that is the library, take its buffer now: where it finds no memory for it
/// later, it tries for ever. Error: there is none. Of this rank alone.
PetscErrorCode take_blas_buffer();

/// Bytes that all ranks may still take together where each takes the same: the ranks of a machine
/// share what is free there, and none goes beyond its own limit. Collective; the same on all ranks.
PetscErrorCode free_memory(MPI_Comm comm, double *bytes);

}  // namespace trefoil
