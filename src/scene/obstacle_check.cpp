#include "scene/obstacle_check.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <sstream>

#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {

using contact::Vector3;

void check_facets(const SurfaceMesh &surface, const std::string &file, bool is_plane) {
  for (std::size_t k = 0; is_plane && k < surface.points.size(); ++k) {
    const double z = surface.points[k][2];
    if (z == 0) continue;
    std::ostringstream height;
    height << z;
    throw InputError("vertex " + std::to_string(k + 1) + " of '" + file + "' has z = " +
                     height.str() + "; the obstacle of a plane body lies in its plane, z = 0");
  }
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

/// A point of something that no cell of another may have in it.
struct Place {
  Vector3 point;
  int body = -1;  ///< that it belongs to; -1: none
};

/// The place of one that lies in a cell of another body, the last of all ranks'; -1: there is none.
/// Collective. @param places the same on all ranks
PetscErrorCode find_within(const Mesh &mesh, const std::vector<Place> &places, int *within) {
  std::vector<int> by_x(places.size());
  const auto x_of = [&](int k) { return places[static_cast<std::size_t>(k)].point.x; };
  PetscFunctionBeginUser;
  *within = -1;
  std::iota(by_x.begin(), by_x.end(), 0);
  std::sort(by_x.begin(), by_x.end(), [&](int a, int b) { return x_of(a) < x_of(b); });
  for (PetscInt c = 0; c < mesh.local_cells(); ++c) {
    const PetscInt *const cell = &mesh.cells[static_cast<std::size_t>(c * mesh.nodes_per_cell())];
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (int a = 0; a <= mesh.dimension(); ++a) {
      const double x = contact::point_of(mesh.coordinates, static_cast<int>(cell[a])).x;
      low = std::min(low, x);
      high = std::max(high, x);
    }
    const auto first = std::lower_bound(by_x.begin(), by_x.end(), low,
                                        [&](int k, double limit) { return x_of(k) < limit; });
    for (auto k = first; k != by_x.end() && x_of(*k) <= high; ++k) {
      const Place &place = places[static_cast<std::size_t>(*k)];
      const bool is_other = place.body != mesh.part[static_cast<std::size_t>(cell[0])];
      if (is_other && contains(mesh, cell, place.point)) *within = std::max(*within, *k);
    }
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, within, 1, MPI_INT, MPI_MAX,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode check_outside(const Mesh &mesh, const std::vector<ObstacleSurface> &surfaces) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  for (const ObstacleSurface &surface : surfaces) {
    std::vector<Place> places;
    int within = -1;
    for (const Vector3 &point : surface.points) places.push_back({point});
    PetscCall(find_within(mesh, places, &within));
    PetscCheck(
        within < 0, comm, PETSC_ERR_USER_INPUT,
        "obstacle '%s' lies within a body at the start; contact needs a start where all are apart",
        surface.name.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_bodies_apart(const Mesh &mesh, const ContactSurface &surface) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  std::vector<Place> places;
  std::vector<char> has_place(static_cast<std::size_t>(mesh.parts), 0);
  int within = -1;
  PetscFunctionBeginUser;
  if (mesh.parts < 2) PetscFunctionReturn(PETSC_SUCCESS);
  // Surfaces do not cross: of a body that is in another one every vertex is.
  for (const contact::SurfaceVertex &vertex : surface.surface().vertices) {
    if (vertex.body >= mesh.parts || has_place[static_cast<std::size_t>(vertex.body)]++) continue;
    places.push_back({vertex.rest, vertex.body});
  }
  PetscCall(find_within(mesh, places, &within));
  if (within < 0) PetscFunctionReturn(PETSC_SUCCESS);
  const Place &inner = places[static_cast<std::size_t>(within)];
  SETERRQ(comm, PETSC_ERR_USER_INPUT,
          "a body lies within another one at rest, where it has a vertex at (%g, %g, %g); contact "
          "needs a start where all are apart",
          inner.point.x, inner.point.y, inner.point.z);
}

}  // namespace trefoil
