#include "scene/region_options.hpp"

#include <algorithm>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode read_regions(MPI_Comm comm, OptionReader &reader, const MaterialOptions &material,
                            std::vector<RegionOptions> *regions) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.names("regions", "Names of parts with materials of their own", &names));
  for (const std::string &name : names) {
    const std::string option = "region_" + name;
    PetscCheck(std::count(names.begin(), names.end(), name) == 1, comm, PETSC_ERR_USER_INPUT,
               "-regions names '%s' twice; give each region its own name", name.c_str());
    RegionOptions region{name, "", "", material};
    PetscCall(reader.text(option + "_where",
                          "Which cells: an expression at their rest centroids, in x y z xmin..zmax",
                          &region.where));
    PetscCall(reader.text(option + "_group",
                          "Instead: name or number of a physical group of the Gmsh file",
                          &region.group));
    PetscCheck(region.where.empty() != region.group.empty(), comm, PETSC_ERR_USER_INPUT,
               "region '%s' needs either -%s_where or -%s_group: say which cells it takes",
               name.c_str(), option.c_str(), option.c_str());
    PetscCall(read_material(comm, reader, option + "_material", &region.material));
    regions->push_back(region);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
