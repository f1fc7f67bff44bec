#include "support/text_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "support/part_file.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

bool is_same_file(const struct stat &one, const struct stat &other) {
  return one.st_dev == other.st_dev && one.st_ino == other.st_ino;
}

/// What the program itself prints to, where that is what `path` names: /dev/stdout, redirected to a
/// file or not. A second opening of it would write over what has been printed.
std::FILE *own_stream(const struct stat &there) {
  for (std::FILE *own : {stdout, stderr}) {
    struct stat opened;
    if (fstat(fileno(own), &opened) == 0 && is_same_file(opened, there)) return own;
  }
  return nullptr;
}

/// Writes all of `text` and closes the file, unless it is the program's own; what went wrong, or
/// nothing.
std::string write_and_close(std::FILE *file, const std::string &text) {
  if (!file) return std::strerror(errno);
  bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  written = std::fflush(file) == 0 && written;
  const int error = errno;
  const bool closed = file == stdout || file == stderr || std::fclose(file) == 0;
  if (!written) return std::strerror(error);
  return closed ? "" : std::strerror(errno);
}

std::string write_to_stream(const std::string &path, const std::string &text) {
  struct stat there;
  if (stat(path.c_str(), &there) != 0) return std::strerror(errno);
  std::FILE *own = own_stream(there);
  return write_and_close(own ? own : std::fopen(path.c_str(), "w"), text);
}

std::string replace_file(const std::string &path, const std::string &text) {
  std::string problem;
  const std::string part = make_part(path, &problem);
  if (!problem.empty()) return problem;
  problem = write_and_close(std::fopen(part.c_str(), "w"), text);
  if (problem.empty() && std::rename(part.c_str(), path.c_str()) != 0) {
    problem = std::strerror(errno);
  }
  if (!problem.empty()) std::remove(part.c_str());
  return problem;
}

/// A disk that is full takes a part of the text: what stands there then goes again.
std::string append_to_file(const std::string &path, const std::string &text) {
  struct stat before;
  const bool is_known = stat(path.c_str(), &before) == 0 && S_ISREG(before.st_mode);
  std::string problem = write_and_close(std::fopen(path.c_str(), "a"), text);
  if (!problem.empty() && is_known && truncate(path.c_str(), before.st_size) != 0) {
    problem += "; its last line is not whole";
  }
  return problem;
}

std::string find_obstacle(const std::string &path) {
  if (is_stream(path)) return access(path.c_str(), W_OK) == 0 ? "" : std::strerror(errno);
  std::string problem;
  remove_stale_parts(follow_links(path));
  const std::string part = make_part(follow_links(path), &problem);
  if (problem.empty()) std::remove(part.c_str());
  return problem;
}

/// Makes the first rank's problem an error on all.
PetscErrorCode agree(MPI_Comm comm, const std::string &path, const std::string &found) {
  char problem[256] = "";
  PetscFunctionBeginUser;
  std::snprintf(problem, sizeof problem, "%s", found.c_str());
  PetscCallMPI(MPI_Bcast(problem, sizeof problem, MPI_CHAR, 0, comm));
  PetscCheck(!problem[0], comm, PETSC_ERR_FILE_OPEN, "cannot write the file '%s': %s", path.c_str(),
             problem);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::string follow_links(const std::string &path) {
  constexpr int most_links = 40;  // as many as the kernel follows
  std::filesystem::path place = path;
  std::error_code error;
  for (int links = 0; links < most_links && std::filesystem::is_symlink(place, error); ++links) {
    const auto target = std::filesystem::read_symlink(place, error);
    if (error) break;
    place = target.is_absolute() ? target : place.parent_path() / target;
  }
  return place.string();
}

bool is_stream(const std::string &path) {
  struct stat there;
  if (stat(path.c_str(), &there) != 0) return false;
  if (S_ISREG(there.st_mode)) return own_stream(there) != nullptr;
  return !S_ISDIR(there.st_mode);
}

std::string find_no_room(const std::string &file, PetscInt64 bytes) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return std::strerror(errno);
  const off_t size = lseek(descriptor, 0, SEEK_END);
  const int full = posix_fallocate(descriptor, size, static_cast<off_t>(bytes));
  const bool is_as_before = ftruncate(descriptor, size) == 0;
  close(descriptor);
  // Other errors only mean that the file system cannot reserve.
  const bool is_full = full == ENOSPC || full == EFBIG || full == EDQUOT || !is_as_before;
  return is_full ? std::strerror(full ? full : errno) : "";
}

PetscErrorCode write_text_file(MPI_Comm comm, const std::string &path, const std::string &text) {
  PetscMPIInt rank = 0;
  std::string problem;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) {
    problem =
        is_stream(path) ? write_to_stream(path, text) : replace_file(follow_links(path), text);
  }
  PetscCall(agree(comm, path, problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode append_text_file(MPI_Comm comm, const std::string &path, const std::string &text) {
  PetscMPIInt rank = 0;
  std::string problem;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  if (rank == 0) problem = append_to_file(path, text);
  PetscCall(agree(comm, path, problem));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_text_file(MPI_Comm comm, const std::string &path) {
  PetscMPIInt rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(agree(comm, path, rank == 0 ? find_obstacle(path) : ""));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
