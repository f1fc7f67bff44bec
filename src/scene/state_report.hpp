#pragma once

#include "output/run_report.hpp"
#include "scene/scene.hpp"

namespace trefoil {

/// What the body does at the scene's displacement, an equilibrium at time t: reactions, forces,
/// extremes, probes. `iterations` is left alone. Collective.
PetscErrorCode describe_state(Scene &scene, double t, StateReport *state);

/// The reaction of each vertex that this rank owns, 3 a local vertex: the force by which it is
/// held; 0 where it is free. Collective.
PetscErrorCode reactions_of_vertices(const Scene &scene, std::vector<double> *reactions);

}  // namespace trefoil
