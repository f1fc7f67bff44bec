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

/// Of forces on vertices, 3 a local one, what acts along directions in which they are held.
std::vector<double> held_part(const Scene &scene, const std::vector<double> &forces);

}  // namespace trefoil
