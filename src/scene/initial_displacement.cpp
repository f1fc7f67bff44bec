#include "scene/initial_displacement.hpp"

#include <utility>

#include "input/expression.hpp"
#include "input/selection.hpp"
#include "mesh/cell_list.hpp"
#include "scene/body_materials.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Displacements of the local vertices, 3 a vertex. Throws InputError.
std::vector<double> evaluate(const std::string &text, const Mesh &mesh) {
  const std::string option = "-initial_displacement";
  const Expression expression(text, option, box_of(mesh));
  std::vector<double> displacement;
  displacement.reserve(mesh.coordinates.size());
  for (PetscInt v = 0; v < mesh.local_vertices(); ++v) {
    for (double value : expression.evaluate(&mesh.coordinates[static_cast<std::size_t>(3 * v)], 0,
                                            static_cast<std::size_t>(mesh.dimension()))) {
      if (Expression::is_free(value)) {
        throw InputError(option + ": 'free' is for constraints; a start is a displacement");
      }
      displacement.push_back(value);
    }
    if (mesh.dimension() == 2) displacement.push_back(0);
  }
  return displacement;
}

}  // namespace

std::string choose_initial(const SceneOptions &options) {
  if (options.initial != "auto") return options.initial;
  if (options.time.is_on) return "rest";
  // Elements with a pressure of their own are led from there by a softer body, see soften_start().
  const bool is_dear = is_nearly_incompressible(options) && options.element_pressure != "constant";
  return is_dear ? "harmonic" : "arap";
}

PetscErrorCode check_initial_steps(MPI_Comm comm, const SceneOptions &options) {
  PetscBool has_steps = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-initial_steps", &has_steps));
  const std::string initial = choose_initial(options);
  PetscCheck(!has_steps || initial == "arap", comm, PETSC_ERR_USER_INPUT,
             "-initial_steps is for -initial arap; the start is '%s'", initial.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_initial_displacement(const std::string &expression,
                                        const Discretization &discretization, Vec x) {
  const Mesh &mesh = discretization.mesh();
  std::vector<double> displacement;
  PetscFunctionBeginUser;
  const std::string complaint = complaint_of([&] { displacement = evaluate(expression, mesh); });
  PetscCall(agree_on_complaint(PetscObjectComm(reinterpret_cast<PetscObject>(x)), complaint));
  PetscCall(set_unknowns(std::move(displacement), discretization, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode set_unknowns(std::vector<double> displacement, const Discretization &discretization,
                            Vec x) {
  PetscInt begin = 0, end = 0;
  PetscScalar *values = nullptr;
  PetscFunctionBeginUser;
  discretization.turn_to_axes(displacement.data());
  PetscCall(VecGetOwnershipRange(x, &begin, &end));
  PetscCall(VecGetArray(x, &values));
  const std::vector<PetscInt> &dofs = discretization.global_dofs();
  for (std::size_t k = 0; k < dofs.size(); ++k) {
    if (dofs[k] >= begin && dofs[k] < end) values[dofs[k] - begin] = displacement[k];
  }
  PetscCall(VecRestoreArray(x, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
