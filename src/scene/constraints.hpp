#pragma once

#include <vector>

#include "assembly/discretization.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// Evaluates the constraints at the rest positions of the mesh's vertices. Collective. Errors, one
/// sentence on all ranks: a malformed expression, a selection that catches no vertex, constraints
/// that disagree on a vertex.
PetscErrorCode hold_vertices(const Mesh &mesh, const std::vector<ConstraintOptions> &constraints,
                             double time, HeldDofs *held);

/// Refuses constraints that leave a rigid-body mode of the body, or of one of its connected parts,
/// free: the Hessian would be singular. Collective.
PetscErrorCode check_rigid_body_modes(const Mesh &mesh, const HeldDofs &held);

}  // namespace trefoil
