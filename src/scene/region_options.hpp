#pragma once

#include <string>
#include <vector>

#include "scene/material_options.hpp"

namespace trefoil {

/// A part of the body with a material of its own: the cells where an expression holds, or those of
/// one of the mesh file's groups.
struct RegionOptions {
  std::string name;
  std::string where;  ///< expression, non-zero at the rest centroids of its cells; or
  std::string group;  ///< name or number of a physical group of the mesh file
  MaterialOptions material;
};

/// Reads -regions and, for each name, -region_NAME_where or _group and -region_NAME_material_...;
/// what a region does not say of its material it takes from `material`. Collective.
PetscErrorCode read_regions(MPI_Comm comm, OptionReader &reader, const MaterialOptions &material,
                            std::vector<RegionOptions> *regions);

}  // namespace trefoil
