#include "support/free_memory.hpp"

#include <dlfcn.h>
#include <sys/resource.h>
#include <unistd.h>
// PETSc's names for LAPACK need the types of the header above.
#include <petscblaslapack.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The number in a file that has but one; `unlimited` where it has none, such as `max`.
double number_in(const std::string &path) {
  double number = unlimited;
  std::ifstream file(path);
  return file >> number ? number : unlimited;
}

/// The number after a word at the beginning of a line.
double number_after(const std::string &path, const std::string &word) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string first;
    double number = 0;
    if (words >> first >> number && first == word) return number;
  }
  return unlimited;
}

/// What a control group has left, by its files' names.
double left_in(const std::string &folder, const char *limit, const char *usage,
               const char *reclaimable) {
  const double most = number_in(folder + limit), used = number_in(folder + usage);
  if (most == unlimited || used == unlimited) return unlimited;
  double cache = number_after(folder + "memory.stat", reclaimable);
  if (cache == unlimited) cache = 0;
  return std::max(0.0, most - std::max(0.0, used - cache));
}

/// The least that the group at `path`, or one above it, has left. Inside a container the group's
/// own path may not be there: then the uppermost one is the container's.
double left_on_the_way(const std::string &top, std::string path, const char *limit,
                       const char *usage, const char *reclaimable) {
  double least = unlimited;
  while (true) {
    const std::string folder = top + (path == "/" ? "" : path) + "/";
    least = std::min(least, left_in(folder, limit, usage, reclaimable));
    if (path.empty() || path == "/") return least;
    path.erase(path.rfind('/'));
  }
}

double left_in_control_groups(const std::string &root) {
  double least = unlimited;
  std::ifstream groups(root + "proc/self/cgroup");
  // Lines: number, controllers, path; version 2 names no controllers.
  for (std::string line; std::getline(groups, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const std::string path = line.substr(second + 1);
    if (controllers.empty()) {
      least = std::min(least, left_on_the_way(root + "sys/fs/cgroup", path, "memory.max",
                                              "memory.current", "inactive_file"));
    } else if (("," + controllers + ",").find(",memory,") != std::string::npos) {
      least = std::min(least,
                       left_on_the_way(root + "sys/fs/cgroup/memory", path, "memory.limit_in_bytes",
                                       "memory.usage_in_bytes", "total_inactive_file"));
    }
  }
  return least;
}

}  // namespace

double free_bytes_of_machine(const std::string &root) {
  const double kilobytes = number_after(root + "proc/meminfo", "MemAvailable:");
  return std::min(1024 * kilobytes, left_in_control_groups(root));
}

double free_bytes_of_process(const std::string &root) {
  struct rlimit limit {};
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return unlimited;
  const double pages = number_in(root + "proc/self/statm");
  if (pages == unlimited) return unlimited;
  const double used = pages * static_cast<double>(sysconf(_SC_PAGESIZE));
  return std::max(0.0, static_cast<double>(limit.rlim_cur) - used);
}

PetscErrorCode free_memory(MPI_Comm comm, double *bytes) {
  MPI_Comm machine = MPI_COMM_NULL;
  PetscMPIInt ranks = 0, ranks_here = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine));
  PetscCallMPI(MPI_Comm_size(machine, &ranks_here));
  PetscCallMPI(MPI_Comm_free(&machine));
  double mine = std::min(free_bytes_of_machine() / ranks_here, free_bytes_of_process());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &mine, 1, MPI_DOUBLE, MPI_MIN, comm));
  *bytes = ranks * mine;
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool has_room_for(std::size_t bytes) {
  void *volatile place = std::malloc(bytes);  // volatile: or the compiler leaves it out
  std::free(place);
  return place != nullptr;
}

PetscErrorCode take_blas_buffer() {
  constexpr std::size_t buffer = std::size_t{130} << 20;
  const PetscBLASInt size = 2, work_size = 64;
  double A[4] = {1, 0, 0, 1}, eigenvalues[2], work[64];
  PetscBLASInt info = 0;
  PetscFunctionBeginUser;
  if (!dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(has_room_for(buffer), PETSC_COMM_SELF, PETSC_ERR_MEM,
             "there is not enough memory for the linear algebra library, which takes 128 MB");
  LAPACKsyev_("N", "U", &size, A, &size, eigenvalues, work, &work_size, &info);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
