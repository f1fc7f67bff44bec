#include "scene/constraints.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "scene/expression.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

double box_diagonal(const Mesh &mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    sum += (mesh.box_max[i] - mesh.box_min[i]) * (mesh.box_max[i] - mesh.box_min[i]);
  }
  return std::sqrt(sum);
}

/// Which constraint holds a dof; -1: none.
using Holder = std::vector<int>;

std::string disagreement(const Mesh &mesh, PetscInt v, const std::string &one,
                         const std::string &other, int component) {
  std::ostringstream text;
  const double *p = &mesh.coordinates[static_cast<std::size_t>(3 * v)];
  text << "constraints '" << one << "' and '" << other << "' move the vertex at rest position ("
       << p[0] << ", " << p[1] << ", " << p[2] << ") differently in "
       << "xyz"[component];
  return text.str();
}

/// Holds what one constraint selects on this rank; returns how many owned vertices it takes.
/// Throws InputError.
PetscInt hold(const Mesh &mesh, const std::vector<ConstraintOptions> &constraints, int which,
              double time, Holder &holder, HeldDofs *held) {
  const ConstraintOptions &constraint = constraints[static_cast<std::size_t>(which)];
  const std::string option = "-constraint_" + constraint.name;
  const Expression where(constraint.where, option + "_where", mesh.box_min, mesh.box_max);
  const std::string zero = mesh.dimension() == 2 ? "0, 0" : "0, 0, 0";
  const Expression move(constraint.move.empty() ? zero : constraint.move, option + "_move",
                        mesh.box_min, mesh.box_max);
  const double tolerance = 1e-12 * box_diagonal(mesh);
  PetscInt taken = 0;
  for (PetscInt v = 0; v < mesh.local_vertices(); ++v) {
    const double *position = &mesh.coordinates[static_cast<std::size_t>(3 * v)];
    const double chosen = where.evaluate(position, time, 1)[0];
    if (Expression::is_free(chosen)) {
      throw InputError(option +
                       "_where: 'free' is for displacements, not for a choice of vertices");
    }
    if (chosen == 0) continue;
    taken += mesh.owned[static_cast<std::size_t>(v)];
    const std::vector<double> target =
        move.evaluate(position, time, static_cast<std::size_t>(mesh.dimension()));
    for (int i = 0; i < mesh.dimension(); ++i) {
      const auto dof = static_cast<std::size_t>(3 * v + i);
      const double value = target[static_cast<std::size_t>(i)];
      if (Expression::is_free(value)) continue;
      if (held->held[dof] && std::abs(held->value[dof] - value) > tolerance) {
        const auto &other = constraints[static_cast<std::size_t>(holder[dof])];
        throw InputError(disagreement(mesh, v, other.name, constraint.name, i));
      }
      if (held->held[dof]) continue;
      held->held[dof] = 1;
      held->value[dof] = value;
      holder[dof] = which;
    }
  }
  return taken;
}

}  // namespace

PetscErrorCode hold_vertices(const Mesh &mesh, const std::vector<ConstraintOptions> &constraints,
                             double time, HeldDofs *held) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  *held = nothing_held(mesh);
  Holder holder(mesh.coordinates.size(), -1);
  for (int which = 0; which < static_cast<int>(constraints.size()); ++which) {
    const ConstraintOptions &constraint = constraints[static_cast<std::size_t>(which)];
    PetscInt taken = 0;
    const std::string complaint =
        complaint_of([&] { taken = hold(mesh, constraints, which, time, holder, held); });
    PetscCall(agree_on_complaint(comm, complaint));
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &taken, 1, MPIU_INT, MPI_SUM, comm));
    PetscCheck(taken > 0, comm, PETSC_ERR_USER_INPUT,
               "constraint '%s' catches no vertex: -constraint_%s_where is '%s' and the mesh spans "
               "[%g, %g] x [%g, %g] x [%g, %g]",
               constraint.name.c_str(), constraint.name.c_str(), constraint.where.c_str(),
               mesh.box_min[0], mesh.box_max[0], mesh.box_min[1], mesh.box_max[1], mesh.box_min[2],
               mesh.box_max[2]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
