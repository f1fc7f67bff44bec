#include "scene/obstacle_check.hpp"

#include <algorithm>

#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {

using contact::Vector3;

void check_facets(const SurfaceMesh &surface, const std::string &file, bool is_plane) {
  for (std::size_t k = 0; k < surface.facets.size(); ++k) {
    const auto &facet = surface.facets[k];
    if ((facet[2] < 0) != is_plane) {
      throw InputError("'" + file + "' has " +
                       (is_plane ? "triangles; a plane body meets segments, lines `l` of an .obj"
                                 : "segments; a body in space meets triangles"));
    }
    const auto side = [&](int corner) {
      const auto &from = surface.points[static_cast<std::size_t>(facet[0])];
      const auto &to = surface.points[static_cast<std::size_t>(facet[corner])];
      return Vector3{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    };
    const double extent =
        is_plane ? contact::norm(side(1)) : contact::norm(contact::cross(side(1), side(2)));
    if (extent > 0) continue;
    throw InputError((is_plane ? "segment " : "triangle ") + std::to_string(k + 1) + " of '" +
                     file + "' has no " + (is_plane ? "length" : "area") +
                     "; remove it from the file");
  }
}

namespace {

/// Whether a local cell has the point in it or on its rim: no corner's share of it is negative.
bool contains(const Mesh &mesh, const PetscInt *cell, const Vector3 &point) {
  const int corners = mesh.dimension() + 1;
  const auto share = [&](int replaced) {
    Vector3 at[4];
    for (int k = 0; k < corners; ++k) {
      at[k] =
          k == replaced ? point : contact::point_of(mesh.coordinates, static_cast<int>(cell[k]));
    }
    const Vector3 area = contact::cross(at[1] - at[0], at[2] - at[0]);
    return corners == 3 ? area.z : contact::dot(area, at[3] - at[0]);
  };
  const double whole = share(-1);
  for (int k = 0; k < corners; ++k) {
    if (share(k) * whole < 0) return false;
  }
  return true;
}

}  // namespace

PetscErrorCode check_outside(const Mesh &mesh, const std::vector<ObstacleSurface> &surfaces) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  const auto before = [](const Vector3 &a, const Vector3 &b) { return a.x < b.x; };
  PetscFunctionBeginUser;
  for (const ObstacleSurface &surface : surfaces) {
    std::vector<Vector3> points = surface.points;
    PetscMPIInt within = 0;
    std::sort(points.begin(), points.end(), before);
    for (PetscInt c = 0; c < mesh.local_cells() && !within; ++c) {
      const PetscInt *const cell = &mesh.cells[static_cast<std::size_t>(c * mesh.nodes_per_cell())];
      Vector3 low = contact::point_of(mesh.coordinates, static_cast<int>(cell[0])), high = low;
      for (int a = 1; a <= mesh.dimension(); ++a) {
        const Vector3 corner = contact::point_of(mesh.coordinates, static_cast<int>(cell[a]));
        low.x = std::min(low.x, corner.x);
        high.x = std::max(high.x, corner.x);
      }
      within = std::any_of(std::lower_bound(points.begin(), points.end(), low, before),
                           std::upper_bound(points.begin(), points.end(), high, before),
                           [&](const Vector3 &point) { return contains(mesh, cell, point); });
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &within, 1, MPI_INT, MPI_MAX, comm));
    PetscCheck(
        !within, comm, PETSC_ERR_USER_INPUT,
        "obstacle '%s' lies within a body at rest; contact needs a start where all are apart",
        surface.name.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
