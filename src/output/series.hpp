#pragma once

#include <memory>
#include <nlohmann/json.hpp>

#include "output/snapshot.hpp"

namespace trefoil {

/// States of one mesh, one after the other, in one output. After every state the files are whole: a
/// run that is killed leaves what it had. Nothing that was written is opened again (of appends to
/// one HDF5 file a kill between two of its writes leaves nothing that can be read).
///
/// - `.xdmf`: a temporal collection. name.h5 has the mesh (/points, /cells) once, name_0000.h5 the
///   fields of the first state (/vertex_fields/displacement), and so on. The description is renamed
///   last each time. It is put together from what was said before, and written whole: at the
///   thousandth state 2 MB, in 1 of the 6 ms that a small body's output takes.
/// - `.vtu`: a file for each state (name_0000.vtu), which name.pvd lists by time; name.vtu is the
///   last one's.
class Series {
 public:
  Series();
  ~Series();
  Series(const Series &) = delete;
  Series &operator=(const Series &) = delete;

  /// Takes a mesh; writes nothing yet. Collective. The ending of `path` decides on the format.
  PetscErrorCode open(MPI_Comm comm, const std::string &path, const OutputMesh &mesh);

  /// Writes the state at time t. Collective; errors as those of write_snapshot().
  PetscErrorCode append(double t, const std::vector<Field> &fields);

  /// What has been written, for a run that goes on later.
  [[nodiscard]] nlohmann::ordered_json save() const;
  /// After open(): goes on behind these states of save(), which have to be there; what was written
  /// after them is removed. Collective.
  PetscErrorCode go_on(const nlohmann::ordered_json &written);

  /// Writes a single state, to which time means nothing; nothing can be appended to it.
  PetscErrorCode write_only(const std::vector<Field> &fields);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace trefoil
