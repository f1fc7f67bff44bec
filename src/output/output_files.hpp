#pragma once

#include <petscsys.h>

#include <filesystem>
#include <functional>
#include <string>

namespace trefoil {

/// Formats of output.
enum class OutputFormat { xdmf, vtu, unknown };

/// By the ending of the name.
OutputFormat format_of_output(const std::filesystem::path &path);

/// Refuses a place where no file can be written and renamed, with one sentence on all ranks; leaves
/// nothing behind, and removes what dead runs have left of it. Collective.
PetscErrorCode check_place(MPI_Comm comm, const std::string &file);

/// What is in the way of writing an output to `path`, as one sentence; nothing where all is well.
std::string find_obstacle(const std::filesystem::path &path);

/// "cannot write the output file 'bar.xdmf': why"
std::string cannot_write(const std::filesystem::path &file, const std::string &why);

/// The place of a file, links followed, and a part of it that is written first. The part goes with
/// this unless it was given its name.
class FileInParts {
 public:
  explicit FileInParts(const std::filesystem::path &path);
  FileInParts(const FileInParts &) = delete;
  FileInParts &operator=(const FileInParts &) = delete;
  ~FileInParts();

  [[nodiscard]] const std::filesystem::path &path() const { return path_; }
  [[nodiscard]] const std::filesystem::path &part() const { return part_; }

  // On one rank; each @return one sentence where it fails, or nothing.
  /// Creates an empty part under a name that no other run has.
  std::string create();
  /// Writes the whole text of the part.
  std::string write(const std::string &text);
  /// Gives the part its name.
  std::string publish();

  /// Tells all ranks the part that the first rank has created. Collective.
  PetscErrorCode share(MPI_Comm comm);

 private:
  std::filesystem::path path_, part_;
  bool is_mine_ = false;
};

/// Writes a file of all ranks beside its place, where the disk has room for it, and gives it its
/// name. Collective; PETSC_ERR_FILE_OPEN on all ranks, with one sentence, where it cannot be
/// written: what stood there stays then.
/// @param write the collective writing of the part, which is there, and empty
/// @param stale a description of the file that was there, or empty: removed just before
PetscErrorCode write_whole(MPI_Comm comm, const std::filesystem::path &file, PetscInt64 bytes,
                           const std::function<PetscErrorCode(const std::string &part)> &write,
                           const std::filesystem::path &stale = {});

/// Whether the disk has room for `bytes` more behind a file, which stays as it is.
/// @return one sentence where it has not, or nothing
std::string check_room_on_disk(const std::filesystem::path &file, PetscInt64 bytes);

}  // namespace trefoil
