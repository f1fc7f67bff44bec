#include "scene/regions.hpp"

#include <algorithm>
#include <array>
#include <sstream>

#include "input/expression.hpp"
#include "input/selection.hpp"
#include "mesh/group_members.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// Which local cells a region takes. Throws InputError.
std::vector<char> cells_of(const Mesh &mesh, const RegionOptions &region, double tolerance) {
  const auto cells = static_cast<std::size_t>(mesh.local_cells());
  std::vector<char> taken(cells, 0);
  if (!region.group.empty()) {
    const int dimension = mesh.dimension();
    return cells_of_group(mesh, find_group(mesh.groups, region.group, {&dimension, 1},
                                           "-region_" + region.name + "_group"));
  }
  const std::string option = "-region_" + region.name + "_where";
  const Condition where(region.where, option, box_of(mesh), tolerance);
  for (std::size_t c = 0; c < cells; ++c) {
    taken[c] = where.holds(centroid_of_cell(mesh, c).data(), 1);
  }
  return taken;
}

/// Gives a region its cells and counts them. Throws InputError where one is another's.
PetscInt take(const Mesh &mesh, const std::vector<RegionOptions> &regions, std::size_t which,
              double tolerance, std::vector<int> &region_of_cell) {
  const std::vector<char> taken = cells_of(mesh, regions[which], tolerance);
  for (std::size_t c = 0; c < taken.size(); ++c) {
    if (!taken[c]) continue;
    const int other = region_of_cell[c];
    if (other) {
      const std::array<double, 3> p = centroid_of_cell(mesh, c);
      std::ostringstream text;
      text << "regions '" << regions[static_cast<std::size_t>(other) - 1].name << "' and '"
           << regions[which].name << "' both take the cell at rest position (" << p[0] << ", "
           << p[1] << ", " << p[2] << "); give each cell one material";
      throw InputError(text.str());
    }
    region_of_cell[c] = static_cast<int>(which) + 1;
  }
  return static_cast<PetscInt>(std::count(taken.begin(), taken.end(), 1));
}

}  // namespace

PetscErrorCode assign_regions(const Mesh &mesh, const std::vector<RegionOptions> &regions,
                              double where_tolerance, std::vector<int> *region_of_cell) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  region_of_cell->assign(static_cast<std::size_t>(mesh.local_cells()), 0);
  for (std::size_t which = 0; which < regions.size(); ++which) {
    PetscInt count = 0;
    const std::string complaint = complaint_of([&] {
      count =
          take(mesh, regions, which, where_tolerance * box_of(mesh).diagonal(), *region_of_cell);
    });
    PetscCall(agree_on_complaint(comm, complaint));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT, MPI_SUM, comm));
    const RegionOptions &region = regions[which];
    PetscCheck(count > 0, comm, PETSC_ERR_USER_INPUT,
               "region '%s' takes no cell: -region_%s_%s is '%s'", region.name.c_str(),
               region.name.c_str(), region.where.empty() ? "group" : "where",
               (region.where.empty() ? region.group : region.where).c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode measure_regions(const Mesh &mesh, const SceneOptions &options,
                               const CellStates &cells, std::vector<RegionReport> *reports) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  std::vector<double> sums(2 * (options.regions.size() + 1), 0);  // cells and volume of each
  const std::vector<int> &region = cells.region_of_cell();
  for (std::size_t c = 0; c < region.size(); ++c) {
    sums[2 * static_cast<std::size_t>(region[c])] += 1;
    sums[2 * static_cast<std::size_t>(region[c]) + 1] += cells.rest_volume(c);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<PetscMPIInt>(sums.size()),
                             MPI_DOUBLE, MPI_SUM, comm));
  reports->clear();
  for (std::size_t k = 0; k <= options.regions.size(); ++k) {
    const double density =
        k == 0 ? options.material.density : options.regions[k - 1].material.density;
    if (k == 0 && sums[0] == 0) continue;
    reports->push_back({k == 0 ? "body" : options.regions[k - 1].name,
                        static_cast<PetscInt64>(sums[2 * k]), sums[2 * k + 1],
                        density * sums[2 * k + 1]});
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
