#pragma once

#include <petscvec.h>

#include <memory>
#include <vector>

#include "output/run_report.hpp"
#include "term/mass_matrix.hpp"
#include "time/integrator.hpp"

namespace trefoil {

struct Scene;

/// What a scene in time has beside its energy of strain and loads: masses, the scheme, and the
/// displacement, velocity and acceleration of all its vertices, held ones included.
class MovingBody {
 public:
  /// @param scene must outlive this
  explicit MovingBody(Scene &scene);
  MovingBody(const MovingBody &) = delete;
  MovingBody &operator=(const MovingBody &) = delete;
  ~MovingBody();

  /// Adds inertia to the scene's functional, which has its elastic term. Collective. Errors, one
  /// sentence on all ranks: a part without mass, lumped masses of quadratic cells.
  PetscErrorCode set_up(const std::vector<int> &region_of_cell);

  /// Places what is held, and the loads, as they are at t = 0. Collective.
  PetscErrorCode hold_start();
  /// Goes on from the scene's displacement at t = 0: sets the initial velocity. Collective. Errors:
  /// a malformed formula, `free` in it.
  PetscErrorCode start();
  /// Then the initial acceleration a, M a = -g(u) - C v. Collective; the energy at the start must
  /// be finite. The scene's Hessian is lost.
  PetscErrorCode accelerate();

  /// Instead of start(): goes on from the states of a run that was saved, the last of which is the
  /// scene's displacement. Collective.
  PetscErrorCode go_on(double time, Motion state, Motion previous, double previous_step);

  /// Begins the step to a time, or begins it anew with another length: moves what is held, sets the
  /// loads, tells the terms. The unknowns stay where the last step left them. Collective.
  PetscErrorCode begin_step(double length, double time);
  /// Ends it at the scene's displacement. Collective.
  PetscErrorCode accept(double time);
  /// Back to the last state that stands. Collective.
  PetscErrorCode go_back();

  /// Energy and momenta, the angular one about the origin. Collective.
  PetscErrorCode report(MotionReport *report) const;
  /// Displacements, velocities and accelerations, 3 numbers a local vertex.
  [[nodiscard]] const Motion &state() const { return integrator_.state(); }
  [[nodiscard]] const TimeIntegrator &integrator() const { return integrator_; }

 private:
  PetscErrorCode check_masses(const std::vector<int> &region_of_cell) const;
  PetscErrorCode set_time(double time);
  PetscErrorCode balance();
  PetscErrorCode hold(double time, double length, HeldMotion *motion);
  PetscErrorCode set_initial_velocity(std::vector<double> *velocity) const;
  PetscErrorCode solve_for_acceleration(std::vector<double> *acceleration) const;

  Scene &scene_;
  std::shared_ptr<const MassMatrix> mass_;
  TimeIntegrator integrator_;
  HeldMotion held_at_start_;
  double time_of_stand_ = 0;
  Vec stand_ = nullptr;  ///< the unknowns of the last state that stands
};

}  // namespace trefoil
