#pragma once

#include <petscsys.h>

#include <optional>
#include <string>

#include "time/integrator.hpp"

namespace trefoil {

/// Steps in time, as the user describes them. With any of these options a scene has inertia, and t
/// in its formulas is time.
struct TimeOptions {
  bool is_on = false;  ///< whether any is given
  std::optional<double> end, step, least_step;
  std::string integrator = "backward_euler";
  std::optional<double> beta, gamma;                  ///< of newmark; 1/4 and 1/2
  double velocity_tolerance = 1e-3;                   ///< box diagonals per time; 0: off
  std::optional<double> absolute_velocity_tolerance;  ///< instead: length per time; 0: off
  std::string mass = "consistent";                    ///< or "lumped"
  double damping_mass = 0;                            ///< alpha of Rayleigh's alpha M + beta K
  double damping_stiffness = 0;                       ///< beta
  std::string initial_velocity = {};  ///< formula with a value for each dimension; empty: none

  /// Below which no step is halved.
  [[nodiscard]] double shortest_step() const { return least_step.value_or(*step / 1024); }
  [[nodiscard]] IntegratorOptions scheme() const;
  /// Below which a direction over its step's length ends the step, in length per time.
  [[nodiscard]] double tolerated_velocity(double diagonal) const {
    return absolute_velocity_tolerance.value_or(velocity_tolerance * diagonal);
  }
};

/// Refuses, with one sentence on all ranks, what makes no steps. Collective.
PetscErrorCode check_time(MPI_Comm comm, const TimeOptions &options);

}  // namespace trefoil
