#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mesh/mesh.hpp"
#include "output/mesh_fingerprint.hpp"
#include "output/row_order.hpp"
#include "output/written_fields.hpp"

namespace trefoil {

/// What a run can go on from: numbers, and fields with 3 of them for each local vertex.
struct SavedRun {
  nlohmann::ordered_json numbers;
  std::map<std::string, std::vector<double>> fields;
};

/// Saves runs on one mesh in HDF5 files, and reads them, on any number of ranks: fields in the
/// order of the vertices' numbers in the mesh file, /checkpoint the numbers as JSON, letter by
/// letter.
class CheckpointFiles {
 public:
  /// @param mesh must outlive this
  explicit CheckpointFiles(const Mesh &mesh) : mesh_(mesh) {}

  /// Collective. See write_whole() for errors; the last file stays then.
  PetscErrorCode write(const std::string &path, const SavedRun &run);
  /// Collective. PETSC_ERR_USER_INPUT on all ranks, with one sentence, where the file is none, or
  /// was saved on another mesh.
  PetscErrorCode read(const std::string &path, SavedRun *run);
  /// The displacements, 3 a local vertex, of a file that any run has left: its output (.xdmf or its
  /// .h5, of a series the last state; .vtu), or a checkpoint. Collective; errors as those of
  /// read().
  PetscErrorCode read_displacement(const std::string &path, std::vector<double> *displacement);

 private:
  PetscErrorCode prepare();
  PetscErrorCode checks_of(const std::map<std::string, std::vector<double>> &rows,
                           nlohmann::ordered_json *checks) const;
  PetscErrorCode read_field(const WrittenField &field, const nlohmann::ordered_json *numbers,
                            std::vector<double> *values);
  PetscErrorCode check_places(const WrittenField &points);

  const Mesh &mesh_;
  bool is_prepared_ = false;
  RowOrder order_;
  MeshFingerprint fingerprint_;
};

}  // namespace trefoil
