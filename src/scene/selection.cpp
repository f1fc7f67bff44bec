#include "scene/selection.hpp"

#include <algorithm>
#include <sstream>

#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/facet_points.hpp"

namespace trefoil {

Box box_of(const Mesh &mesh) {
  return {mesh.box_min, mesh.box_max};
}

std::string warn_of_rest(const Choice &choice, PetscInt64 count, const std::string &things) {
  std::ostringstream text;
  text << choice.option << " '" << choice.where << "' would take " << count << " more " << things
       << " were they moved by " << choice.tolerance << "; put its limit between vertices";
  return text.str();
}

PetscErrorCode choose_vertices(const Mesh &mesh, const Choice &choice, double time,
                               ChosenVertices *chosen) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  chosen->taken.assign(mesh.owned.size(), 0);
  chosen->nearly.assign(mesh.owned.size(), 0);
  const std::string complaint = complaint_of([&] {
    const Condition where(choice.where, choice.option, box_of(mesh), choice.tolerance);
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      const double *position = &mesh.coordinates[3 * v];
      chosen->taken[v] = where.holds(position, time);
      chosen->nearly[v] = !chosen->taken[v] && where.holds_nearby(position, time, mesh.dimension());
    }
  });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode count_vertices(const Mesh &mesh, const std::vector<char> &marked,
                              PetscInt64 *count) {
  PetscFunctionBeginUser;
  *count = 0;
  for (std::size_t v = 0; v < marked.size(); ++v) *count += marked[v] && mesh.owned[v];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, count, 1, MPIU_INT64, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode choose_facets(const Mesh &mesh, const ChosenVertices &chosen, ChosenFacets *facets) {
  std::vector<Facet> all;
  PetscInt64 counts[2] = {0, 0};
  PetscFunctionBeginUser;
  const auto corners_are = [](const Facet &facet, const auto &marked) {
    return std::all_of(facet.begin(), facet.begin() + facet.corners(), marked);
  };
  const auto taken = [&](PetscInt v) { return chosen.taken[static_cast<std::size_t>(v)] != 0; };
  const auto at_most_nearly = [&](PetscInt v) {
    return taken(v) || chosen.nearly[static_cast<std::size_t>(v)];
  };
  PetscCall(boundary_facets(
      mesh, [&](const Facet &facet) { return corners_are(facet, at_most_nearly); }, &all));
  facets->facets.clear();
  for (const Facet &facet : all) {
    if (corners_are(facet, taken)) facets->facets.push_back(facet);
  }
  counts[0] = static_cast<PetscInt64>(facets->facets.size());
  counts[1] = static_cast<PetscInt64>(all.size()) - counts[0];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPIU_INT64, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm))));
  facets->count = counts[0];
  facets->nearly = counts[1];
  PetscCall(area_of_facets(mesh, facets->facets, &facets->area));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
