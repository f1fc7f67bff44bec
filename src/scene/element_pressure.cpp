#include "scene/element_pressure.hpp"

#include <string>

#include "scene/body_materials.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The first material whose energy is not split; empty: there is none.
std::string whole_material(const SceneOptions &options) {
  for (const MaterialOptions &material : named_materials(options)) {
    if (!make_material(material)->splits_volume()) return material.model;
  }
  return "";
}

}  // namespace

PetscErrorCode choose_element_pressure(const Mesh &mesh, SceneOptions *options) {
  PetscFunctionBeginUser;
  if (options->element_pressure != "auto") PetscFunctionReturn(PETSC_SUCCESS);
  const bool is_constant = is_quadratic(*mesh.shape) && options->filter_space == "element" &&
                           is_nearly_incompressible(*options) && whole_material(*options).empty();
  options->element_pressure = is_constant ? "constant" : "pointwise";
  if (is_constant) {
    PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm)),
                          "elements: with a constant pressure each, as a material is nearly "
                          "incompressible (-element_pressure pointwise: without)\n"));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

ElementPressure element_pressure(const SceneOptions &options) {
  return options.element_pressure == "constant" ? ElementPressure::constant
                                                : ElementPressure::pointwise;
}

PetscErrorCode check_element_pressure(const SceneOptions &options, const Mesh &mesh) {
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
  const std::string whole = whole_material(options);
  PetscCheck(
      whole.empty(), comm, PETSC_ERR_USER_INPUT,
      "-element_pressure constant takes the part of the energy that depends on the volume alone, "
      "and %s has none that can be told from the rest; use another material, such as "
      "stable_neo_hookean, or -element_pressure pointwise",
      whole.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
