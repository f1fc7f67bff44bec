#include "scene/element_pressure.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {

ElementPressure element_pressure(const SceneOptions &options) {
  return options.element_pressure == "constant" ? ElementPressure::constant
                                                : ElementPressure::pointwise;
}

PetscErrorCode check_element_pressure(const SceneOptions &options, const Mesh &mesh,
                                      const MaterialOptions &material, const MaterialModel &model) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  if (element_pressure(options) == ElementPressure::pointwise) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCheck(
      is_quadratic(*mesh.shape), comm, PETSC_ERR_USER_INPUT,
      "-element_pressure constant is for quadratic elements, and these are linear: their J is the "
      "same everywhere; add -order 2");
  PetscCheck(options.filter_space == "element", comm, PETSC_ERR_USER_INPUT,
             "-element_pressure constant couples the quadrature points of an element, and "
             "-snes_trefoil_space deformation filters each on its own; use -snes_trefoil_space "
             "element");
  PetscCheck(
      model.splits_volume(), comm, PETSC_ERR_USER_INPUT,
      "-element_pressure constant takes the part of the energy that depends on the volume alone, "
      "and %s has none that can be told from the rest; use another material, such as "
      "stable_neo_hookean, or -element_pressure pointwise",
      material.model.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
