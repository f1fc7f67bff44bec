#include "output/checkpoint_file.hpp"

#include <petscis.h>
#include <petscviewerhdf5.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "mesh/io/hdf5_reader.hpp"
#include "mesh/io/list_check.hpp"
#include "output/hdf5_file.hpp"
#include "output/mesh_output.hpp"
#include "output/output_files.hpp"
#include "output/written_fields.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

constexpr int version = 2;
const char *const numbers_dataset = "/checkpoint";
const char *const group = "/fields";
const char *const advice = "; name a file that -checkpoint has written";

MPI_Comm comm_of(const Mesh &mesh) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
}

std::string dataset_of(const std::string &field) {
  return std::string(group) + "/" + field;
}

/// FNV-1a [Fowler, Noll, Vo 1991]: a text of which a letter is another one has another number.
std::uint64_t check_of(const std::string &text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char letter : text) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3;
  }
  return hash;
}

/// Writes a text as a list of the numbers of its letters, from the first rank.
PetscErrorCode write_text(PetscViewer viewer, const std::string &name, const std::string &text) {
  const MPI_Comm comm = PetscObjectComm((PetscObject)viewer);
  IS letters = nullptr;
  PetscMPIInt rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  std::vector<PetscInt> numbers;
  if (rank == 0) numbers.assign(text.begin(), text.end());
  PetscCall(ISCreateGeneral(comm, static_cast<PetscInt>(numbers.size()), numbers.data(),
                            PETSC_COPY_VALUES, &letters));
  PetscErrorCode outcome = PetscObjectSetName((PetscObject)letters, name.c_str());
  if (!outcome) outcome = ISView(letters, viewer);
  PetscCall(ISDestroy(&letters));
  PetscCall(outcome);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The numbers of a checkpoint. Throws InputError.
Json read_numbers(const std::string &path) {
  if (!std::ifstream(path)) {
    throw InputError("cannot read '" + path + "': " + std::strerror(errno));
  }
  const Hdf5Reader file(path, advice);
  if (!file.has(numbers_dataset)) file.fail("is no checkpoint of Trefoil");
  const auto letters = file.integers(numbers_dataset, 0, file.size(numbers_dataset));
  const std::string text(letters.begin(), letters.end());
  const std::size_t end = text.rfind(' ');  // before its check
  const bool is_whole = end != std::string::npos &&
                        text.substr(end + 1) == std::to_string(check_of(text.substr(0, end)));
  if (!is_whole) file.fail("is damaged, or of another version of Trefoil");
  Json numbers = Json::parse(text.substr(0, end), nullptr, false);
  if (!numbers.is_object() || numbers.value("checkpoint", 0) != version) {
    file.fail("is no checkpoint that this version of Trefoil can read");
  }
  return numbers;
}

/// Throws InputError where the checkpoint is of another mesh.
void check_mesh(const MeshFingerprint &fingerprint, const Json &numbers, const std::string &path) {
  std::string difference;
  try {
    difference = fingerprint.difference(numbers.at("mesh"));
  } catch (const Json::exception &) {
    throw InputError(path + " is damaged" + advice);
  }
  if (!difference.empty()) throw InputError(path + " is of another mesh: " + difference);
}

}  // namespace

PetscErrorCode CheckpointFiles::prepare() {
  PetscFunctionBeginUser;
  if (is_prepared_) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<PetscInt> numbers;
  for (std::size_t v = 0; v < mesh_.owned.size(); ++v) {
    if (mesh_.owned[v]) numbers.push_back(mesh_.vertex_number[v]);
  }
  PetscCall(order_.set_up(comm_of(mesh_), numbers));
  PetscCall(fingerprint_.take(mesh_));
  is_prepared_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Of each field, by the rows that ranks have of it, what kept_check() makes of it. Collective.
PetscErrorCode CheckpointFiles::checks_of(const std::map<std::string, std::vector<double>> &rows,
                                          Json *checks) const {
  PetscFunctionBeginUser;
  *checks = Json::object();
  for (const auto &[name, values] : rows) {
    std::uint64_t sum =
        check_of_entries(PetscInt64{3} * order_.first(), std::span<const double>(values));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm_of(mesh_)));
    (*checks)[name] = kept_check(sum);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointFiles::write(const std::string &path, const SavedRun &run) {
  constexpr PetscInt64 hdf5_itself = 1 << 20;
  std::map<std::string, std::vector<double>> rows;
  PetscFunctionBeginUser;
  PetscCall(prepare());
  Json numbers{{"checkpoint", version}, {"mesh", fingerprint_.json()}, {"fields", Json::array()}};
  for (const auto &[name, values] : run.fields) {
    numbers["fields"].push_back(name);
    PetscCall(order_.arrange(values_of_owned(mesh_, values.data(), 3), 3, &rows[name]));
  }
  numbers.update(run.numbers);
  PetscCall(checks_of(rows, &numbers["checks"]));
  std::string text = numbers.dump();
  text += ' ' + std::to_string(check_of(text));
  const auto bytes = static_cast<PetscInt64>(sizeof(PetscInt) * text.size()) +
                     static_cast<PetscInt64>(3 * sizeof(double) * rows.size()) * order_.total();
  PetscCall(write_whole(comm_of(mesh_), path, bytes + hdf5_itself, [&](const std::string &part) {
    return with_hdf5(comm_of(mesh_), part, FILE_MODE_WRITE, [&](PetscViewer viewer) {
      PetscFunctionBeginUser;
      PetscCall(write_text(viewer, numbers_dataset + 1, text));
      PetscCall(PetscViewerHDF5PushGroup(viewer, group));
      for (const auto &[name, values] : rows) PetscCall(write_reals(viewer, name, 3, values));
      PetscCall(PetscViewerHDF5PopGroup(viewer));
      PetscFunctionReturn(PETSC_SUCCESS);
    });
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The vectors of a file, 3 numbers for each vertex in their order, for the local vertices.
/// @param numbers of a checkpoint, which has the field's check, or null
PetscErrorCode CheckpointFiles::read_field(const WrittenField &field, const Json *numbers,
                                           std::vector<double> *values) {
  std::map<std::string, std::vector<double>> rows;
  Json found;
  const std::string name = field.dataset.substr(field.dataset.rfind('/') + 1);
  PetscFunctionBeginUser;
  const std::string complaint = complaint_of(
      [&] { rows[name] = field.read(order_.total(), order_.first(), order_.share()); });
  PetscCall(agree_on_complaint(comm_of(mesh_), complaint));
  if (numbers && numbers->contains("checks")) {  // the numbers have been checked themselves
    PetscCall(checks_of(rows, &found));
    PetscCheck(numbers->at("checks").value(name, PetscInt{-1}) == found[name], comm_of(mesh_),
               PETSC_ERR_USER_INPUT, "%s is damaged in %s: it is not what was written%s",
               field.path.c_str(), field.dataset.c_str(), advice);
  }
  PetscCall(order_.fetch(mesh_.vertex_number, rows[name], 3, values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointFiles::read(const std::string &path, SavedRun *run) {
  PetscFunctionBeginUser;
  PetscCall(prepare());
  const std::string complaint = complaint_of([&] {
    run->numbers = read_numbers(path);
    check_mesh(fingerprint_, run->numbers, path);
  });
  PetscCall(agree_on_complaint(comm_of(mesh_), complaint));
  for (const Json &name : run->numbers["fields"]) {
    PetscCall(read_field({path, dataset_of(name)}, &run->numbers, &run->fields[name]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Vertices of another mesh may be as many.
PetscErrorCode CheckpointFiles::check_places(const WrittenField &points) {
  constexpr double near = 1e-9;  // of the box's diagonal
  std::vector<double> places;
  double apart = 0, diagonal = 0;
  PetscFunctionBeginUser;
  PetscCall(read_field(points, nullptr, &places));
  for (std::size_t i = 0; i < 3; ++i) {
    diagonal = std::hypot(diagonal, mesh_.box_max[i] - mesh_.box_min[i]);
  }
  for (std::size_t k = 0; k < places.size(); ++k) {
    apart = std::max(apart, std::abs(places[k] - mesh_.coordinates[k]));
  }
  const std::string complaint =
      apart <= near * diagonal
          ? ""
          : points.path + " is of another mesh: as many vertices there as here, in other places";
  PetscCall(agree_on_complaint(comm_of(mesh_), complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode CheckpointFiles::read_displacement(const std::string &path,
                                                  std::vector<double> *displacement) {
  WrittenDisplacement found;
  Json numbers;  // of a checkpoint
  PetscFunctionBeginUser;
  PetscCall(prepare());
  const std::string complaint = complaint_of([&] {
    const bool is_checkpoint = has_dataset(path, numbers_dataset);
    if (is_checkpoint) numbers = read_numbers(path);
    if (is_checkpoint) check_mesh(fingerprint_, numbers, path);
    found = is_checkpoint ? WrittenDisplacement{{path, dataset_of("displacement")}, {}}
                          : find_displacement(path);
  });
  PetscCall(agree_on_complaint(comm_of(mesh_), complaint));
  PetscCall(read_field(found.values, numbers.is_null() ? nullptr : &numbers, displacement));
  if (!found.points.path.empty()) PetscCall(check_places(found.points));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
