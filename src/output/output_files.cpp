#include "output/output_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "output/snapshot.hpp"
#include "support/collective_error.hpp"
#include "support/part_file.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {
namespace {

std::filesystem::path directory_of(const std::filesystem::path &path) {
  return path.has_parent_path() ? path.parent_path() : ".";
}

/// "its name must end in .xdmf or .vtu; for .msh: meshio convert bar.xdmf bar.msh ..."
std::string text_of_endings(const std::filesystem::path &path) {
  const std::string ending = path.extension().string();
  std::string text = "its name must end in .xdmf or .vtu";
  if (ending.empty()) return text;
  const std::string stem = path.stem().string();
  return text + "; " + ending + " is made of that: meshio convert " + stem + ".xdmf " + stem +
         ending + (ending == ".msh" ? " --output-format gmsh" : "");
}

/// What is in the way of creating `file`.
std::string obstacle_of(const std::filesystem::path &file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored))
    return cannot_write(file, "a directory of this name is in the way");
  if (is_stream(file.string())) return cannot_write(file, "it is a device or a pipe; name a file");
  if (!std::filesystem::is_directory(directory_of(file), ignored))
    return cannot_write(file, "there is no directory '" + directory_of(file).string() + "'");
  remove_stale_parts(file.string());
  return FileInParts(file).create();
}

/// A PETSc error of one rank as a sentence for all. Collective.
PetscErrorCode agree_on_writing(MPI_Comm comm, const std::string &file, PetscErrorCode outcome) {
  int error = static_cast<int>(outcome);
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &error, 1, MPI_INT, MPI_MAX, comm));
  const std::string why = "writing it failed, PETSc's error " + std::to_string(error);
  PetscCall(agree_on_complaint(comm, error ? cannot_write(file, why) : "", PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

OutputFormat format_of_output(const std::filesystem::path &path) {
  if (path.extension() == ".xdmf") return OutputFormat::xdmf;
  return path.extension() == ".vtu" ? OutputFormat::vtu : OutputFormat::unknown;
}

std::vector<std::string> files_of_output(const std::string &path) {
  if (format_of_output(path) != OutputFormat::xdmf) return {path};
  return {path, std::filesystem::path(path).replace_extension(".h5").string()};
}

std::string cannot_write(const std::filesystem::path &file, const std::string &why) {
  return "cannot write the output file '" + file.string() + "': " + why;
}

std::string find_obstacle(const std::filesystem::path &path) {
  const OutputFormat format = format_of_output(path);
  if (format == OutputFormat::unknown) return cannot_write(path, text_of_endings(path));
  if (format == OutputFormat::xdmf && path.filename().string().find(':') != std::string::npos)
    return cannot_write(path, "XDMF allows no colon in a file name");
  for (const std::string &file : files_of_output(follow_links(path.string()))) {
    const std::string obstacle = obstacle_of(follow_links(file));
    if (!obstacle.empty()) return obstacle;
  }
  return "";
}

FileInParts::FileInParts(const std::filesystem::path &path) : path_(follow_links(path.string())) {}

FileInParts::~FileInParts() {
  std::error_code ignored;
  if (is_mine_) std::filesystem::remove(part_, ignored);
}

std::string FileInParts::create() {
  std::string problem;
  part_ = make_part(path_.string(), &problem);
  is_mine_ = problem.empty();
  return problem.empty() ? "" : cannot_write(path_, problem);
}

std::string FileInParts::write(const std::string &text) {
  std::ofstream stream(part_, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  return stream ? "" : cannot_write(path_, std::strerror(errno));
}

std::string FileInParts::publish() {
  std::error_code error;
  std::filesystem::rename(part_, path_, error);
  if (error) return cannot_write(path_, error.message());
  is_mine_ = false;
  return "";
}

PetscErrorCode FileInParts::share(MPI_Comm comm) {
  std::string name = part_.string();
  auto length = static_cast<PetscMPIInt>(name.size());
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, 0, comm));
  name.resize(static_cast<std::size_t>(length));
  PetscCallMPI(MPI_Bcast(name.data(), length, MPI_CHAR, 0, comm));
  part_ = name;
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::string check_room_on_disk(const std::filesystem::path &file, PetscInt64 bytes) {
  const std::string problem = find_no_room(file.string(), bytes);
  return problem.empty() ? "" : cannot_write(file, problem);
}

PetscErrorCode write_whole(MPI_Comm comm, const std::filesystem::path &file, PetscInt64 bytes,
                           const std::function<PetscErrorCode(const std::string &part)> &write,
                           const std::filesystem::path &stale) {
  FileInParts whole(file);
  std::string problem;
  int rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  // A disk that fills up in the middle of a collective write leaves ranks waiting for ever in
  // HDF5 (seen with 1.10.8 on a small disk): whether there is room is settled before.
  if (rank == 0) problem = whole.create();
  if (rank == 0 && problem.empty()) problem = check_room_on_disk(whole.part(), bytes);
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(whole.share(comm));
  PetscCall(agree_on_writing(comm, file.string(), write(whole.part().string())));
  if (rank == 0) {
    std::error_code error;
    if (!stale.empty()) std::filesystem::remove(stale, error);
    problem = error ? cannot_write(stale, error.message()) : whole.publish();
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_place(MPI_Comm comm, const std::string &file) {
  int rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(agree_on_complaint(comm, rank == 0 ? obstacle_of(follow_links(file)) : "",
                               PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_writable(MPI_Comm comm, const std::string &path) {
  int rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(agree_on_complaint(comm, rank == 0 ? find_obstacle(path) : "", PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
