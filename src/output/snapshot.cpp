#include "output/snapshot.hpp"

#include <fcntl.h>
#include <hdf5.h>
#include <petscis.h>
#include <petscvec.h>
#include <petscviewerhdf5.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <type_traits>
#include <vector>

#include "output/xdmf.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {
namespace {

static_assert(std::is_same_v<PetscScalar, double>,
              "the files hold doubles: Trefoil needs a PETSc of real numbers in double precision");

/// The names under which the two files appear, and those they are written under.
struct Files {
  std::filesystem::path xdmf, data, xdmf_part, data_part;

  explicit Files(const std::string &path) : xdmf(follow_links(path)) {
    data = follow_links(std::filesystem::path(xdmf).replace_extension(".h5").string());
  }
};

void remove_parts(const Files &files) {
  std::error_code ignored;
  std::filesystem::remove(files.xdmf_part, ignored);
  std::filesystem::remove(files.data_part, ignored);
}

std::string cannot_write(const std::filesystem::path &file, const std::string &why) {
  return "cannot write the output file '" + file.string() + "': " + why;
}

/// Sets `bytes` of the disk aside for a file that is there. @return one sentence, or nothing
std::string reserve(const std::filesystem::path &file, PetscInt64 bytes) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return cannot_write(file, std::strerror(errno));
  const int full = posix_fallocate(descriptor, 0, static_cast<off_t>(bytes));
  close(descriptor);
  // Other errors only mean that the file system cannot reserve.
  const bool is_full = full == ENOSPC || full == EFBIG || full == EDQUOT;
  return is_full ? cannot_write(file, std::strerror(full)) : "";
}

/// Creates both parts, under names that no other run has. @return one sentence, or nothing
std::string make_parts(Files &files) {
  std::string problem;
  files.xdmf_part = make_part(files.xdmf.string(), &problem);
  if (problem.empty()) files.data_part = make_part(files.data.string(), &problem);
  return problem.empty() ? "" : cannot_write(files.xdmf, problem);
}

/// Tells all ranks the data's part, which they write together.
PetscErrorCode share_data_part(MPI_Comm comm, Files *files) {
  std::string name = files->data_part.string();
  auto length = static_cast<PetscMPIInt>(name.size());
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(&length, 1, MPI_INT, 0, comm));
  name.resize(static_cast<std::size_t>(length));
  PetscCallMPI(MPI_Bcast(name.data(), length, MPI_CHAR, 0, comm));
  files->data_part = name;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// One rank's look at the target. @return one sentence, or nothing where all is well
std::string find_obstacle(const Files &files) {
  if (files.xdmf.extension() != ".xdmf")
    return cannot_write(files.xdmf, "its name must end in .xdmf");
  if (files.xdmf.filename().string().find(':') != std::string::npos)
    return cannot_write(files.xdmf, "XDMF allows no colon in a file name");
  std::error_code ignored;
  for (const auto &target : {files.xdmf, files.data})
    if (std::filesystem::is_directory(target, ignored))
      return cannot_write(target, "a directory of this name is in the way");
  for (const auto &target : {files.xdmf, files.data})
    if (is_stream(target.string()))
      return cannot_write(target, "it is a device or a pipe; name a file");
  const auto directory = files.xdmf.has_parent_path() ? files.xdmf.parent_path() : ".";
  if (!std::filesystem::is_directory(directory, ignored))
    return cannot_write(files.xdmf, "there is no directory '" + directory.string() + "'");

  Files parts = files;
  const std::string obstacle = make_parts(parts);
  remove_parts(parts);
  return obstacle;
}

/// @return whether the sizes of the snapshot's arrays fit together, and it can be said in XDMF
bool is_consistent(const Snapshot &snapshot) {
  const auto dim = static_cast<std::size_t>(snapshot.dim);
  const auto corners = static_cast<std::size_t>(snapshot.corners);
  if (dim != 2 && dim != 3) return false;
  if (corners != 3 && corners != 4 && corners != 6 && corners != 10) return false;
  if (snapshot.points.size() % dim != 0 || snapshot.cells.size() % corners != 0) return false;
  for (const auto &field : snapshot.fields) {
    const auto places =
        field.on_vertices ? snapshot.points.size() / dim : snapshot.cells.size() / corners;
    if (field.components != 1 && field.components != xdmf::coordinates) return false;
    if (field.values.size() != places * static_cast<std::size_t>(field.components)) return false;
    if (field.name.empty() || field.name.find('/') != std::string::npos) return false;
  }
  return true;
}

/// Collective: checks every rank's part and adds the parts up.
PetscErrorCode count(MPI_Comm comm, const Snapshot &snapshot, xdmf::Totals *totals) {
  PetscFunctionBeginUser;
  int consistent = is_consistent(snapshot) ? 1 : 0;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &consistent, 1, MPI_INT, MPI_MIN, comm));
  PetscCheck(consistent, comm, PETSC_ERR_ARG_SIZ,
             "the arrays of a snapshot must fit its points and cells on every rank: "
             "1 or 3 components a field, 3, 4, 6 or 10 nodes a cell");
  std::array<PetscInt64, 2> sums{static_cast<PetscInt64>(snapshot.points.size()) / snapshot.dim,
                                 static_cast<PetscInt64>(snapshot.cells.size()) / snapshot.corners};
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPIU_INT64, MPI_SUM, comm));
  *totals = {sums[0], sums[1]};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// @return room that the data file needs, in bytes
PetscInt64 size_in_bytes(const Snapshot &snapshot, const xdmf::Totals &totals) {
  constexpr PetscInt64 hdf5_itself = 1 << 20;  // generous: some 4 kB a dataset were seen
  PetscInt64 doubles = totals.points * xdmf::coordinates;
  for (const auto &field : snapshot.fields)
    doubles += (field.on_vertices ? totals.points : totals.cells) * field.components;
  return doubles * static_cast<PetscInt64>(sizeof(double)) +
         totals.cells * snapshot.corners * static_cast<PetscInt64>(sizeof(PetscInt)) + hdf5_itself;
}

/// Writes a dataset of `components` columns (a plain list where that is 1), rank below rank.
PetscErrorCode write_reals(PetscViewer viewer, const std::string &name, int components,
                           const std::vector<double> &values) {
  Vec vector = nullptr;

  PetscFunctionBeginUser;
  PetscCall(VecCreateMPIWithArray(PetscObjectComm((PetscObject)viewer), components,
                                  static_cast<PetscInt>(values.size()), PETSC_DETERMINE,
                                  values.data(), &vector));
  PetscErrorCode outcome = PetscObjectSetName((PetscObject)vector, name.c_str());
  if (!outcome) outcome = VecView(vector, viewer);
  PetscCall(VecDestroy(&vector));
  PetscCall(outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Writes the connectivity as a dataset of cells x corners, rank below rank.
PetscErrorCode write_cells(PetscViewer viewer, const Snapshot &snapshot) {
  IS corners = nullptr;

  PetscFunctionBeginUser;
  PetscCall(ISCreateGeneral(PetscObjectComm((PetscObject)viewer),
                            static_cast<PetscInt>(snapshot.cells.size()), snapshot.cells.data(),
                            PETSC_USE_POINTER, &corners));
  PetscErrorCode outcome = PetscObjectSetName((PetscObject)corners, xdmf::cells_dataset);
  if (!outcome) outcome = ISSetBlockSize(corners, snapshot.corners);
  if (!outcome) outcome = ISView(corners, viewer);
  PetscCall(ISDestroy(&corners));
  PetscCall(outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// @return owned vertices x 3: the points, with z = 0 where the mesh is flat
std::vector<double> points_in_space(const Snapshot &snapshot) {
  if (snapshot.dim == xdmf::coordinates) return snapshot.points;
  std::vector<double> padded;
  padded.reserve(snapshot.points.size() / 2 * xdmf::coordinates);
  for (std::size_t point = 0; point < snapshot.points.size(); point += 2)
    padded.insert(padded.end(), {snapshot.points[point], snapshot.points[point + 1], 0.0});
  return padded;
}

PetscErrorCode write_datasets(PetscViewer viewer, const Snapshot &snapshot) {
  PetscFunctionBeginUser;
  PetscCall(
      write_reals(viewer, xdmf::points_dataset, xdmf::coordinates, points_in_space(snapshot)));
  PetscCall(write_cells(viewer, snapshot));
  for (const auto &field : snapshot.fields) {
    PetscCall(PetscViewerHDF5PushGroup(viewer, xdmf::group_of(field)));
    PetscCall(write_reals(viewer, field.name, field.components, field.values));
    PetscCall(PetscViewerHDF5PopGroup(viewer));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Collective, but where the disk fails on some ranks the outcome may differ between ranks.
/// What PETSc and HDF5 say about a failure fills pages: both are kept silent here.
PetscErrorCode write_data(MPI_Comm comm, const std::string &file, const Snapshot &snapshot) {
  PetscViewer viewer = nullptr;
  H5E_auto2_t printer = nullptr;
  void *printer_data = nullptr;

  PetscFunctionBeginUser;
  H5Eget_auto2(H5E_DEFAULT, &printer, &printer_data);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr));
  PetscErrorCode outcome = PetscViewerHDF5Open(comm, file.c_str(), FILE_MODE_WRITE, &viewer);
  if (!outcome) outcome = write_datasets(viewer, snapshot);
  const PetscErrorCode closing = PetscViewerDestroy(&viewer);
  PetscCall(PetscPopErrorHandler());
  H5Eset_auto2(H5E_DEFAULT, printer, printer_data);
  PetscFunctionReturn(outcome ? outcome : closing);
}

/// One rank: writes the XDMF part and gives both files their names.
/// @return one sentence, or nothing where all is well
std::string publish(const Files &files, const std::string &description) {
  std::ofstream stream(files.xdmf_part, std::ios::binary | std::ios::trunc);
  stream << description;
  stream.close();
  if (!stream) return cannot_write(files.xdmf, std::strerror(errno));

  // The old description goes first: at no moment does one stand beside data that it does not fit.
  std::error_code error;
  std::filesystem::remove(files.xdmf, error);
  if (!error) std::filesystem::rename(files.data_part, files.data, error);
  if (!error) std::filesystem::rename(files.xdmf_part, files.xdmf, error);
  return error ? cannot_write(files.xdmf, error.message()) : "";
}

}  // namespace

PetscErrorCode check_writable(MPI_Comm comm, const std::string &path) {
  int rank = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(
      agree_on_complaint(comm, rank == 0 ? find_obstacle(Files(path)) : "", PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode write_snapshot(MPI_Comm comm, const std::string &path, const Snapshot &snapshot) {
  Files files(path);
  xdmf::Totals totals;
  int rank = 0;

  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCall(count(comm, snapshot, &totals));
  PetscCall(check_writable(comm, path));

  // A disk that fills up in the middle of a collective write leaves ranks waiting for ever in
  // HDF5 (seen with 1.10.8 on a small disk): whether there is room is settled before.
  std::string problem;
  if (rank == 0) {
    problem = make_parts(files);
    if (problem.empty()) problem = reserve(files.data_part, size_in_bytes(snapshot, totals));
    if (!problem.empty()) remove_parts(files);
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscCall(share_data_part(comm, &files));

  int outcome = static_cast<int>(write_data(comm, files.data_part.string(), snapshot));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &outcome, 1, MPI_INT, MPI_MAX, comm));

  if (rank == 0) {
    problem =
        outcome ? cannot_write(files.data, "HDF5 failed, PETSc's error " + std::to_string(outcome))
                : publish(files, xdmf::describe(files.data.filename(), snapshot, totals));
    if (!problem.empty()) remove_parts(files);
  }
  PetscCall(agree_on_complaint(comm, problem, PETSC_ERR_FILE_OPEN));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
