#pragma once

#include "output/series.hpp"
#include "scene/scene.hpp"

namespace trefoil {

/// Names of all fields that an output may have, and those that it has unless it is told.
std::vector<std::string> names_of_fields();
std::vector<std::string> default_fields(const SceneOptions &options);

/// Asks whether the files that the options name can be written, before a long solve. Collective.
PetscErrorCode check_outputs(MPI_Comm comm, const SceneOptions &options);

/// The states of a scene in the output that its options name; nothing where they name none. Fields
/// are computed only if they are named. Stresses and strains are written by cell, and by vertex as
/// the mean of its cells by rest volume; where regions meet, of those of the region with the
/// greater von Mises stress there.
class FieldOutput {
 public:
  /// @param is_series whether states follow each other in time, or there is one
  FieldOutput(Scene &scene, bool is_series) : scene_(scene), is_series_(is_series) {}

  /// Writes the state that the scene is at. Collective.
  PetscErrorCode write(double t);

  /// What has been written of a series, for a run that goes on later.
  [[nodiscard]] nlohmann::ordered_json save() const;
  /// Goes on with the series of a run that was saved, where it is in the same files. Collective.
  PetscErrorCode go_on(const nlohmann::ordered_json &saved);

 private:
  PetscErrorCode open();
  PetscErrorCode make_fields(std::vector<Field> *fields) const;

  Scene &scene_;
  bool is_series_, is_open_ = false;
  Series series_;
  ObstacleOutput obstacles_;
};

}  // namespace trefoil
