#pragma once

#include <vector>

#include "scene/scene.hpp"

namespace trefoil {

/// By how much the total energy of a run in time, strain, kinetic and contact energy less the work
/// of the loads, has risen above the least that it has been, as a share of the largest sum of the
/// first three; 0 where nothing happens. No scheme may add energy to a scene in which nothing
/// prescribed moves and no load changes.
double find_energy_rise(const std::vector<StateReport> &states);

/// Whether a rise is more than a scheme's error, and nothing that is prescribed accounts for it.
/// Collective.
PetscErrorCode is_energy_made(Scene &scene, const std::vector<StateReport> &states, double rise,
                              bool *made);

}  // namespace trefoil
