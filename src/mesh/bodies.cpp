#include "mesh/bodies.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace trefoil {
namespace {

using Rotation = std::array<std::array<double, 3>, 3>;

/// Rodrigues' formula: R = cos a I + sin a [n]x + (1 - cos a) n n'.
Rotation rotation_of(const Placement &placement) {
  const auto &axis = placement.axis;
  const double length = std::hypot(axis[0], axis[1], axis[2]);
  const double angle = placement.degrees * std::numbers::pi / 180;
  const double c = std::cos(angle), s = std::sin(angle);
  const double n[3] = {axis[0] / length, axis[1] / length, axis[2] / length};
  Rotation R{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) R[i][j] += (i == j ? c : 0) + (1 - c) * n[i] * n[j];
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    R[j][i] += s * n[k];
    R[i][j] -= s * n[k];
  }
  return R;
}

/// Groups of one body in a mesh of several: places in the list, and sets, of what it had.
class JoinedGroups {
 public:
  JoinedGroups(const CellList &mesh, const std::string &body, Groups &all) : all_(all) {
    for (const Group &group : mesh.groups.list()) {
      places_.push_back(all.add(group.dimension, group.number, body));
      all.name(places_.back(), group.name);
    }
    sets_ = mesh.groups.sets();
    whole_ = all.add(mesh.dimension(), Group::whole, body);
  }

  [[nodiscard]] PetscInt set_of(PetscInt set, bool is_cell) {
    std::vector<int> groups;
    for (const int group : sets_[static_cast<std::size_t>(set)]) {
      groups.push_back(places_[static_cast<std::size_t>(group)]);
    }
    if (is_cell) groups.push_back(whole_);
    return all_.set_of(std::move(groups));
  }

 private:
  Groups &all_;
  std::vector<int> places_;
  std::vector<std::vector<int>> sets_;
  int whole_ = 0;
};

void append_groups(const CellList &mesh, const std::string &body, PetscInt first_vertex,
                   Groups &all) {
  JoinedGroups joined(mesh, body, all);
  // Few different sets occur, and neighbours mostly have the same.
  PetscInt last = -1, last_joined = 0;
  for (PetscInt c = 0; c < mesh.size(); ++c) {
    const PetscInt set =
        mesh.groups.set_of_cell.empty() ? 0 : mesh.groups.set_of_cell[static_cast<std::size_t>(c)];
    if (set != last) last_joined = joined.set_of(last = set, true);
    all.set_of_cell.push_back(last_joined);
  }
  for (std::size_t dimension = 0; dimension < all.below.size(); ++dimension) {
    const GroupedEntities &entities = mesh.groups.below[dimension];
    for (const PetscInt vertex : entities.vertices) {
      all.below[dimension].vertices.push_back(first_vertex + vertex);
    }
    for (const PetscInt set : entities.sets) {
      all.below[dimension].sets.push_back(joined.set_of(set, false));
    }
  }
}

/// One kind of cells, and no more than can be numbered.
void check_kinds(const std::vector<CellList> &meshes, const std::vector<BodySource> &bodies) {
  double entries = 0;
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const CellShape &first = *meshes.front().shape, &other = *meshes[k].shape;
    entries += static_cast<double>(meshes[k].cells.size() + meshes[k].coordinates.size());
    if (&first == &other) continue;
    throw InputError("the bodies of a scene have cells of one kind, but '" + bodies.front().name +
                     "' has " + first.name + " and '" + bodies[k].name + "' has " + other.name +
                     (first.dimension == other.dimension
                          ? "; give -order 1, or mesh them alike"
                          : "; a scene is either in the plane or in space"));
  }
  if (entries > static_cast<double>(std::numeric_limits<PetscInt>::max()))
    throw InputError("the bodies of the scene have more cells than can be numbered");
}

}  // namespace

void place(CellList &mesh, const Placement &placement) {
  const Rotation R = rotation_of(placement);
  for (std::size_t v = 0; v < mesh.coordinates.size(); v += 3) {
    std::array<double, 3> x{};
    for (std::size_t i = 0; i < 3; ++i) x[i] = placement.scale * mesh.coordinates[v + i];
    for (std::size_t i = 0; i < 3; ++i) {
      const double turned =
          placement.degrees == 0 ? x[i] : R[i][0] * x[0] + R[i][1] * x[1] + R[i][2] * x[2];
      mesh.coordinates[v + i] = turned + placement.shift[i];
    }
  }
}

CellList join_bodies(const std::vector<CellList> &meshes, const std::vector<BodySource> &bodies) {
  check_kinds(meshes, bodies);
  CellList all;
  all.shape = meshes.front().shape;
  PetscInt first_cell = 0;
  for (std::size_t k = 0; k < meshes.size(); ++k) {
    const CellList &mesh = meshes[k];
    const PetscInt first_vertex = all.vertices();
    all.bodies.push_back({bodies[k].name, all.file_vertices});
    append_groups(mesh, bodies[k].name, first_vertex, all.groups);
    all.coordinates.insert(all.coordinates.end(), mesh.coordinates.begin(), mesh.coordinates.end());
    for (const PetscInt vertex : mesh.cells) all.cells.push_back(first_vertex + vertex);
    for (const PetscInt number : mesh.vertex_number) {
      all.vertex_number.push_back(all.file_vertices + number);
    }
    for (const PetscInt number : mesh.cell_number) all.cell_number.push_back(first_cell + number);
    all.file_vertices += mesh.file_vertices;
    first_cell += mesh.file_cells;
  }
  return all;
}

std::string names_of(const std::vector<BodySource> &bodies) {
  std::string text;
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    text += (k == 0 ? "" : k + 1 == bodies.size() ? " and " : ", ") + bodies[k].name;
  }
  return text;
}

}  // namespace trefoil
