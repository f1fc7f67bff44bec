#include "scene/obstacle_output.hpp"

#include <cmath>
#include <filesystem>
#include <numeric>

#include "input/selection.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using contact::Vector3;

/// All of it on the first rank.
OutputMesh output_mesh(const ObstacleSurface &surface, bool is_first_rank) {
  const bool is_plane = !surface.facets.empty() && surface.facets.front()[2] < 0;
  OutputMesh mesh;
  mesh.shape = is_plane ? &shapes::edge2 : &shapes::tri3;
  if (!is_first_rank) return mesh;
  for (const Vector3 &point : surface.points) {
    mesh.points.insert(mesh.points.end(), {point.x, point.y, point.z});
  }
  for (const auto &facet : surface.facets) {
    mesh.cells.insert(mesh.cells.end(), facet.begin(), facet.begin() + mesh.shape->nodes);
  }
  mesh.point_numbers.resize(surface.points.size());
  mesh.cell_numbers.resize(surface.facets.size());
  std::iota(mesh.point_numbers.begin(), mesh.point_numbers.end(), 0);
  std::iota(mesh.cell_numbers.begin(), mesh.cell_numbers.end(), 0);
  return mesh;
}

}  // namespace

DrawnObstacle draw_half_space(const HalfSpaceObstacle &plane, const Mesh &mesh) {
  constexpr double share = 0.6;  // of the diagonal, to each side
  const Vector3 low = contact::point_of(mesh.box_min, 0), high = contact::point_of(mesh.box_max, 0);
  const Vector3 normal = plane.at_rest.normal, middle = 0.5 * (low + high);
  const Vector3 centre = middle - plane.at_rest.gap(middle) * normal;
  const double half = share * box_of(mesh).diagonal();
  DrawnObstacle drawn{{plane.name, {}, {}}, nullptr};
  if (mesh.dimension() == 2) {
    const Vector3 along{-half * normal.y, half * normal.x, 0};
    drawn.surface.points = {centre - along, centre + along};
    drawn.surface.facets = {{0, 1, -1}};
  } else {
    // Across the normal: the axis that is farthest from it, made so.
    const Vector3 axis =
        std::abs(normal.x) <= std::abs(normal.y) ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    const Vector3 across = contact::cross(normal, axis);
    const Vector3 one = (half / contact::norm(across)) * across;
    const Vector3 other = contact::cross(normal, one);
    drawn.surface.points = {centre - one - other, centre + one - other, centre + one + other,
                            centre - one + other};
    drawn.surface.facets = {{0, 1, 2}, {0, 2, 3}};
  }
  drawn.motion = [displacement = plane.displacement, count = drawn.surface.points.size()](
                     double time) { return std::vector<Vector3>(count, displacement(time)); };
  return drawn;
}

std::string output_of_obstacle(const std::string &output, const std::string &obstacle) {
  const std::filesystem::path path(output);
  return std::filesystem::path(path)
      .replace_filename(path.stem().string() + "." + obstacle + path.extension().string())
      .string();
}

PetscErrorCode ObstacleOutput::open(MPI_Comm comm, const std::vector<DrawnObstacle> &obstacles,
                                    const std::string &output, bool is_series) {
  int rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  is_first_rank_ = rank == 0;
  is_series_ = is_series;
  for (const DrawnObstacle &obstacle : obstacles) {
    Output &opened = outputs_.emplace_back(obstacle);
    PetscCall(opened.series.open(comm, output_of_obstacle(output, obstacle.surface.name),
                                 output_mesh(obstacle.surface, is_first_rank_)));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ObstacleOutput::write(double t) {
  PetscFunctionBeginUser;
  for (auto &[obstacle, series] : outputs_) {
    Field displacement{"displacement", true, 3, {}};
    if (is_first_rank_) {
      for (const Vector3 &u : obstacle.motion(t)) {
        displacement.values.insert(displacement.values.end(), {u.x, u.y, u.z});
      }
    }
    PetscCall(is_series_ ? series.append(t, {displacement}) : series.write_only({displacement}));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

nlohmann::ordered_json ObstacleOutput::save() const {
  auto written = nlohmann::ordered_json::object();
  for (const auto &[obstacle, series] : outputs_) {
    written[obstacle.surface.name] = series.save();
  }
  return written;
}

PetscErrorCode ObstacleOutput::go_on(const nlohmann::ordered_json &written) {
  PetscFunctionBeginUser;
  for (auto &[obstacle, series] : outputs_) {
    const auto known = written.find(obstacle.surface.name);
    if (known != written.end()) PetscCall(series.go_on(*known));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
