#pragma once

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "mesh/mesh.hpp"
#include "output/series.hpp"
#include "term/contact_term.hpp"

namespace trefoil {

/// An obstacle as it is drawn: triangles, of a plane scene segments with -1 as third corner.
struct DrawnObstacle {
  ObstacleSurface surface;
  ObstacleMotion motion;
};

/// A half-space as a patch of its face, a little larger than the body, in front of its middle.
DrawnObstacle draw_half_space(const HalfSpaceObstacle &plane, const Mesh &mesh);

/// "run.floor.xdmf": the output of an obstacle beside that of the body, "run.xdmf".
std::string output_of_obstacle(const std::string &output, const std::string &obstacle);

/// The states of a scene's obstacles, each in an output of its own: where it is at rest, and its
/// displacement.
class ObstacleOutput {
 public:
  /// @param output of the body
  /// @param is_series whether states follow each other in time, or there is one
  /// Collective.
  PetscErrorCode open(MPI_Comm comm, const std::vector<DrawnObstacle> &obstacles,
                      const std::string &output, bool is_series);

  /// Writes where all are at time t. Collective.
  PetscErrorCode write(double t);

  /// See Series.
  [[nodiscard]] nlohmann::ordered_json save() const;
  PetscErrorCode go_on(const nlohmann::ordered_json &written);

 private:
  struct Output {
    DrawnObstacle obstacle;
    Series series{};
  };
  std::deque<Output> outputs_;
  bool is_series_ = false, is_first_rank_ = false;
};

}  // namespace trefoil
