#include "scene/load_options.hpp"

#include <algorithm>

#include "support/petsc_compatibility.hpp"

namespace trefoil {

PetscErrorCode read_loads(MPI_Comm comm, OptionReader &reader, LoadOptions *loads) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.text("load_gravity", "Acceleration: three expressions; needs -material_density",
                        &loads->gravity));
  PetscCall(reader.names("loads", "Names of the tractions, separated by commas", &names));
  for (const std::string &name : names) {
    PetscCheck(std::count(names.begin(), names.end(), name) == 1, comm, PETSC_ERR_USER_INPUT,
               "-loads names '%s' twice; give each load its own name", name.c_str());
    TractionOptions load{name, "", ""};
    PetscCall(reader.text("load_" + name + "_where",
                          "Which facets of the surface: an expression that holds at all their "
                          "vertices, in x y z t xmin..zmax",
                          &load.where));
    PetscCall(reader.text("load_" + name + "_traction", "Force per rest area: three expressions",
                          &load.traction));
    PetscCheck(!load.where.empty() && !load.traction.empty(), comm, PETSC_ERR_USER_INPUT,
               "load '%s' needs -load_%s_where and -load_%s_traction: say which facets it takes "
               "and how it pulls at them",
               name.c_str(), name.c_str(), name.c_str());
    loads->tractions.push_back(load);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
