#include "input/selection.hpp"

#include <algorithm>
#include <sstream>

#include "mesh/group_members.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/facet_points.hpp"

namespace trefoil {
namespace {

MPI_Comm comm_of(const Mesh &mesh) {
  return PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
}

template <class Marked>
bool corners_are(const Facet &facet, const Marked &marked) {
  return std::all_of(facet.begin(), facet.begin() + facet.corners(), marked);
}

/// What a formula takes of all vertices; all of them where there is none.
PetscErrorCode apply_formula(const Mesh &mesh, const Choice &choice, double time,
                             ChosenVertices *chosen) {
  PetscFunctionBeginUser;
  chosen->taken.assign(mesh.owned.size(), choice.where.empty());
  chosen->nearly.assign(mesh.owned.size(), 0);
  if (choice.where.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  const std::string complaint = complaint_of([&] {
    const Condition where(choice.where, choice.option + "_where", box_of(mesh), choice.tolerance);
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      const double *position = &mesh.coordinates[3 * v];
      chosen->taken[v] = where.holds(position, time);
      chosen->nearly[v] = !chosen->taken[v] && where.holds_nearby(position, time, mesh.dimension());
    }
  });
  PetscCall(agree_on_complaint(comm_of(mesh), complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The place of the choice's group in the mesh's list.
PetscErrorCode place_of_group(const Mesh &mesh, const Choice &choice,
                              std::span<const int> dimensions, int *place) {
  PetscFunctionBeginUser;
  const std::string complaint = complaint_of([&] {
    *place = find_group(mesh.groups, choice.group, dimensions, choice.option + "_group");
  });
  PetscCall(agree_on_complaint(comm_of(mesh), complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The facets that a load can act on: those of its group, or all between vertices that are taken or
/// nearly so.
PetscErrorCode candidates_of(const Mesh &mesh, const Choice &choice, const ChosenVertices &vertices,
                             std::vector<Facet> *facets) {
  PetscFunctionBeginUser;
  if (choice.group.empty()) {
    const auto at_most_nearly = [&](PetscInt v) {
      const auto k = static_cast<std::size_t>(v);
      return vertices.taken[k] || vertices.nearly[k];
    };
    PetscCall(boundary_facets(
        mesh, [&](const Facet &facet) { return corners_are(facet, at_most_nearly); }, facets));
  } else {
    const int dimension = mesh.dimension() - 1;
    int place = 0;
    PetscInt inner = 0;
    PetscCall(place_of_group(mesh, choice, {&dimension, 1}, &place));
    PetscCall(facets_of_group(mesh, place, facets, &inner));
    PetscCheck(inner == 0, comm_of(mesh), PETSC_ERR_USER_INPUT,
               "%s_group: %" PetscInt_FMT
               " of the facets in '%s' lie inside of the body, between two cells, where nothing "
               "can pull; choose a group of its surface",
               choice.option.c_str(), inner, choice.group.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::string Choice::text() const {
  const std::string by_where = where.empty() ? "" : option + "_where is '" + where + "'";
  const std::string by_group = group.empty() ? "" : option + "_group is '" + group + "'";
  return by_where + (by_where.empty() || by_group.empty() ? "" : " and ") + by_group;
}

Box box_of(const Mesh &mesh) {
  return {mesh.box_min, mesh.box_max};
}

std::string warn_of_rest(const Choice &choice, PetscInt64 count, const std::string &things) {
  std::ostringstream text;
  text << choice.option << "_where '" << choice.where << "' would take " << count << " more "
       << things << " were they moved by " << choice.tolerance
       << "; put its limit between vertices";
  return text.str();
}

PetscErrorCode depends_on_time(const Mesh &mesh, const Choice &choice, bool *depends) {
  PetscFunctionBeginUser;
  *depends = false;
  if (choice.where.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  const std::string complaint = complaint_of([&] {
    const std::string option = choice.option + "_where";
    *depends = Condition(choice.where, option, box_of(mesh), choice.tolerance).uses_time();
  });
  PetscCall(agree_on_complaint(comm_of(mesh), complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode choose_vertices(const Mesh &mesh, const Choice &choice, double time,
                               ChosenVertices *chosen) {
  PetscFunctionBeginUser;
  PetscCall(apply_formula(mesh, choice, time, chosen));
  if (choice.group.empty()) PetscFunctionReturn(PETSC_SUCCESS);
  // Of groups with one name what holds more comes first, but a volume only if there is no other.
  constexpr int in_space[] = {2, 1, 0, 3}, in_plane[] = {1, 0, 2};
  std::vector<char> in_group;
  int place = 0;
  const bool plane = mesh.dimension() == 2;
  PetscCall(place_of_group(mesh, choice,
                           plane ? std::span<const int>(in_plane) : std::span<const int>(in_space),
                           &place));
  PetscCall(vertices_of_group(mesh, place, &in_group));
  for (std::size_t v = 0; v < in_group.size(); ++v) {
    chosen->taken[v] = chosen->taken[v] && in_group[v];
    chosen->nearly[v] = chosen->nearly[v] && in_group[v];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode count_vertices(const Mesh &mesh, const std::vector<char> &marked,
                              PetscInt64 *count) {
  PetscFunctionBeginUser;
  *count = 0;
  for (std::size_t v = 0; v < marked.size(); ++v) *count += marked[v] && mesh.owned[v];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 1, MPIU_INT64, MPI_SUM, comm_of(mesh)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode area_between(const Mesh &mesh, const ChosenVertices &chosen, double *area) {
  std::vector<Facet> facets;
  PetscFunctionBeginUser;
  const auto taken = [&](PetscInt v) { return chosen.taken[static_cast<std::size_t>(v)] != 0; };
  PetscCall(boundary_facets(
      mesh, [&](const Facet &facet) { return corners_are(facet, taken); }, &facets));
  PetscCall(area_of_facets(mesh, facets, area));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode choose_facets(const Mesh &mesh, const Choice &choice, double time,
                             ChosenFacets *facets) {
  ChosenVertices vertices;
  std::vector<Facet> candidates;
  PetscFunctionBeginUser;
  PetscCall(apply_formula(mesh, choice, time, &vertices));
  PetscCall(candidates_of(mesh, choice, vertices, &candidates));
  const auto taken = [&](PetscInt v) { return vertices.taken[static_cast<std::size_t>(v)] != 0; };
  const auto at_most_nearly = [&](PetscInt v) {
    return taken(v) || vertices.nearly[static_cast<std::size_t>(v)];
  };
  PetscInt64 counts[2] = {0, 0};
  facets->facets.clear();
  for (const Facet &facet : candidates) {
    if (corners_are(facet, taken)) {
      facets->facets.push_back(facet);
    } else {
      counts[1] += corners_are(facet, at_most_nearly);
    }
  }
  counts[0] = static_cast<PetscInt64>(facets->facets.size());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPIU_INT64, MPI_SUM, comm_of(mesh)));
  facets->count = counts[0];
  facets->nearly = counts[1];
  PetscCall(area_of_facets(mesh, facets->facets, &facets->area));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
