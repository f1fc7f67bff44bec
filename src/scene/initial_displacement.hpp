#pragma once

#include <string>

#include "assembly/discretization.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// How -initial auto starts: `arap`, but `harmonic` where a material of the scene is nearly
/// incompressible and elements have no pressure of their own, which is to be chosen before. Fitting
/// rotations ignores volumes, and elements that it inverts often stay so where volume is expensive:
/// on 35 scenes of Poisson's ratio 0.495 the minima found from `arap` lay 0.10 of the energy's
/// scale above the lowest known ones, from `harmonic` 0.03.
std::string choose_initial(const SceneOptions &options);

/// Refuses -initial_steps of a start that takes none. Collective.
PetscErrorCode check_initial_steps(MPI_Comm comm, const SceneOptions &options);

/// Sets the unknowns x to the displacement that an expression with three values says at the rest
/// positions of the vertices, in units of length; held components keep what they are held at.
/// A malformed expression, a value that is not finite or `free` is an error with one sentence on
/// all ranks. Collective.
PetscErrorCode set_initial_displacement(const std::string &expression,
                                        const Discretization &discretization, Vec x);

/// Sets the unknowns x to those of a displacement, or of a change of it, 3 numbers a local vertex;
/// what it has of held components is ignored.
PetscErrorCode set_unknowns(std::vector<double> displacement, const Discretization &discretization,
                            Vec x);

}  // namespace trefoil
