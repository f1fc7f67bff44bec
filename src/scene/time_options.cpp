#include "scene/time_options.hpp"

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Load steps are another meaning of t.
PetscErrorCode refuse_load_steps(MPI_Comm comm) {
  PetscFunctionBeginUser;
  for (const char *option : {"-load_steps", "-load_steps_first", "-load_steps_least"}) {
    PetscBool given = PETSC_FALSE;
    PetscCall(PetscOptionsHasName(nullptr, nullptr, option, &given));
    PetscCheck(!given, comm, PETSC_ERR_USER_INPUT,
               "%s cuts the way of t from 0 to 1 into solves, but with -time_step t is time: leave "
               "out one or the other",
               option);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_scheme(MPI_Comm comm, const TimeOptions &options) {
  const IntegratorOptions scheme = options.scheme();
  PetscFunctionBeginUser;
  PetscCheck(scheme.scheme == TimeScheme::newmark || !(options.beta || options.gamma), comm,
             PETSC_ERR_USER_INPUT,
             "-time_beta and -time_gamma are for -time_integrator newmark; the integrator is '%s'",
             options.integrator.c_str());
  PetscCheck(
      scheme.beta > 0 && scheme.gamma >= 0.5, comm, PETSC_ERR_USER_INPUT,
      "-time_beta is %g and -time_gamma %g; a step is implicit with beta above 0, and stable "
      "with gamma from 0.5 on",
      scheme.beta, scheme.gamma);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// One of the two, with either unit.
PetscErrorCode check_velocity_tolerance(MPI_Comm comm, const TimeOptions &options) {
  PetscBool is_relative = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsHasName(nullptr, nullptr, "-time_velocity_tolerance", &is_relative));
  const auto &absolute = options.absolute_velocity_tolerance;
  PetscCheck(!is_relative || !absolute, comm, PETSC_ERR_USER_INPUT,
             "-time_velocity_tolerance, in box diagonals per time, and "
             "-time_velocity_tolerance_absolute, in length per time, are two units of one "
             "tolerance: leave out one or the other");
  PetscCheck(options.velocity_tolerance >= 0, comm, PETSC_ERR_USER_INPUT,
             "-time_velocity_tolerance is %g and must not be negative", options.velocity_tolerance);
  PetscCheck(absolute.value_or(0) >= 0, comm, PETSC_ERR_USER_INPUT,
             "-time_velocity_tolerance_absolute is %g and must not be negative", *absolute);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

IntegratorOptions TimeOptions::scheme() const {
  const TimeScheme which = integrator == "newmark" ? TimeScheme::newmark
                           : integrator == "bdf2"  ? TimeScheme::bdf2
                                                   : TimeScheme::backward_euler;
  return {which, beta.value_or(0.25), gamma.value_or(0.5)};
}

PetscErrorCode check_time(MPI_Comm comm, const TimeOptions &options) {
  PetscFunctionBeginUser;
  PetscCheck(
      options.end && options.step, comm, PETSC_ERR_USER_INPUT,
      "a scene in time needs -time_end and -time_step: say how long it is, and in what steps");
  PetscCheck(*options.step > 0, comm, PETSC_ERR_USER_INPUT,
             "-time_step is %g; a step in time must be positive", *options.step);
  PetscCheck(*options.end >= *options.step, comm, PETSC_ERR_USER_INPUT,
             "-time_end is %g, less than one -time_step, %g", *options.end, *options.step);
  PetscCheck(*options.end < 1e9 * *options.step, comm, PETSC_ERR_USER_INPUT,
             "-time_end %g in steps of %g are more than 10^9 steps", *options.end, *options.step);
  PetscCheck(options.shortest_step() > 0 && options.shortest_step() <= *options.step, comm,
             PETSC_ERR_USER_INPUT,
             "-time_step_min is %g; it must lie above 0 and not above -time_step, %g",
             options.shortest_step(), *options.step);
  PetscCall(check_velocity_tolerance(comm, options));
  PetscCheck(options.damping_mass >= 0 && options.damping_stiffness >= 0, comm,
             PETSC_ERR_USER_INPUT,
             "-time_damping_mass (%g) and -time_damping_stiffness (%g) must not be negative",
             options.damping_mass, options.damping_stiffness);
  PetscCall(check_scheme(comm, options));
  PetscCall(refuse_load_steps(comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
