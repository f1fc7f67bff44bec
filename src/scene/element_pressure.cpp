#include "scene/element_pressure.hpp"

#include <algorithm>

#include "scene/body_materials.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

bool splits(const MaterialOptions &material) {
  return make_material(material)->splits_volume();
}

/// The first material that is nearly incompressible and whose energy is not split; the first of all
/// where none is; empty: there is none.
std::string whole_material(const SceneOptions &options) {
  const std::vector<MaterialOptions> materials = materials_of_cells(options);
  for (const MaterialOptions &material : materials) {
    if (is_nearly_incompressible(material) && !splits(material)) return material.model;
  }
  return std::any_of(materials.begin(), materials.end(), splits) ? "" : materials.front().model;
}

/// Refuses a constant pressure where there cannot be one. Collective.
PetscErrorCode check_constant(const SceneOptions &options, const Mesh &mesh,
                              const std::string &whole) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  PetscCheck(
      is_quadratic(*mesh.shape), comm, PETSC_ERR_USER_INPUT,
      "-element_pressure constant is for quadratic elements, and these are linear: their J is the "
      "same everywhere; add -order 2");
  PetscCheck(options.filter_space == "element", comm, PETSC_ERR_USER_INPUT,
             "-element_pressure constant couples the quadrature points of an element, and "
             "-snes_trefoil_space deformation filters each on its own; use -snes_trefoil_space "
             "element");
  PetscCheck(
      whole.empty(), comm, PETSC_ERR_USER_INPUT,
      "-element_pressure constant takes the part of the energy that depends on the volume alone, "
      "and %s has none that can be told from the rest; use another material, such as "
      "stable_neo_hookean, or -element_pressure pointwise",
      whole.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Of quadratic elements without it though a material is nearly incompressible.
std::string warn_of_pointwise(const std::string &whole) {
  const std::string reason =
      whole.empty() ? "-snes_trefoil_space deformation filters each point on its own; without it "
                      "elements have a pressure of their own"
                    : whole +
                          " has no volumetric part that elements could take on the mean; others "
                          "have, such as stable_neo_hookean";
  return "quadratic elements lock a little, and their pressure is noise, where a "
         "material is nearly incompressible: " +
         reason;
}

}  // namespace

PetscErrorCode choose_element_pressure(const Mesh &mesh, SceneOptions *options,
                                       std::vector<std::string> *warnings) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  const bool is_given = options->element_pressure != "auto";
  const bool is_better = is_quadratic(*mesh.shape) && is_nearly_incompressible(*options);
  const std::string whole = whole_material(*options);
  PetscFunctionBeginUser;
  if (!is_given) {
    const bool can = whole.empty() && options->filter_space == "element";
    options->element_pressure = is_better && can ? "constant" : "pointwise";
  }
  // By what was given checkpoints tell whether they are of the same scene: chosen is like given.
  options->given.erase("element_pressure");
  if (options->element_pressure == "constant") {
    options->given["element_pressure"] = "constant";
    PetscCall(check_constant(*options, mesh, whole));
    PetscCall(PetscPrintf(comm, "elements: with a constant pressure each, as %s\n",
                          is_given ? "-element_pressure says"
                                   : "a material is nearly incompressible (-element_pressure "
                                     "pointwise: without)"));
  } else if (is_better && is_given) {
    PetscCall(PetscPrintf(comm,
                          "elements: with their volume at the points, as -element_pressure says; "
                          "their pressure is noise where a material is nearly incompressible\n"));
  } else if (is_better) {
    warnings->push_back(warn_of_pointwise(whole));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

ElementPressure element_pressure(const SceneOptions &options) {
  return options.element_pressure == "constant" ? ElementPressure::constant
                                                : ElementPressure::pointwise;
}

}  // namespace trefoil
