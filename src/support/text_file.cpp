#include "support/text_file.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Writes `text` to `path`.part; what went wrong, or nothing.
std::string write_part(const std::string &path, const std::string &text) {
  struct stat there;
  if (stat(path.c_str(), &there) == 0 && S_ISDIR(there.st_mode)) return std::strerror(EISDIR);
  std::FILE *file = std::fopen((path + ".part").c_str(), "w");
  if (!file) return std::strerror(errno);
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const bool closed = std::fclose(file) == 0;
  return written && closed ? "" : std::strerror(errno);
}

/// On the first rank: writes beside, then renames if `keep`, or leaves nothing behind.
PetscErrorCode write(MPI_Comm comm, const std::string &path, const std::string &text, bool keep) {
  PetscMPIInt rank = 0;
  char problem[256] = "";
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    std::string found = write_part(path, text);
    const std::string part = path + ".part";
    if (found.empty() && keep && std::rename(part.c_str(), path.c_str()) != 0) {
      found = std::strerror(errno);
    }
    if (!keep || !found.empty()) std::remove(part.c_str());
    std::snprintf(problem, sizeof problem, "%s", found.c_str());
  }
  PetscCallMPI(MPI_Bcast(problem, sizeof problem, MPI_CHAR, 0, comm));
  PetscCheck(!problem[0], comm, PETSC_ERR_FILE_OPEN, "cannot write the file '%s': %s", path.c_str(),
             problem);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode write_text_file(MPI_Comm comm, const std::string &path, const std::string &text) {
  PetscFunctionBeginUser;
  PetscCall(write(comm, path, text, true));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_text_file(MPI_Comm comm, const std::string &path) {
  PetscFunctionBeginUser;
  PetscCall(write(comm, path, "", false));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
