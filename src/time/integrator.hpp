#pragma once

#include <string>
#include <vector>

#include "term/term.hpp"

namespace trefoil {

/// How displacements of one time become those of the next.
enum class TimeScheme {
  backward_euler,  ///< first order, damps
  bdf2,            ///< second order, damps high frequencies; its first step is backward Euler's
  newmark          ///< second order with gamma = 1/2; then with beta = 1/4 damps nothing
};

struct IntegratorOptions {
  TimeScheme scheme = TimeScheme::backward_euler;
  double beta = 0.25, gamma = 0.5;  ///< of Newmark's scheme
};

/// Displacement, velocity and acceleration, 3 numbers for each local vertex, ghosts and held ones
/// included.
struct Motion {
  std::vector<double> u, v, a;
};

/// Where held components are at the end of a step: they go where their formulas say.
struct HeldMotion {
  std::vector<char> held;  ///< of each number
  Motion at_end;           ///< counts where held
};

/// Turns the states before a step into the energy whose minimum ends it, see StepState, and that
/// minimum into the next state. With the step dt to t_{n+1} and r = dt / dt_{n-1}:
///
///   backward_euler  s = c = dt,  predicted u_n + dt v_n,  v = (u - u_n) / dt
///   bdf2            s = c = dt (1 + r) / (1 + 2r),  predicted uh + c vh,  v = (u - uh) / c,
///                   uh = ((1 + r)^2 u_n - r^2 u_{n-1}) / (1 + 2r),  vh alike
///   newmark         s = dt sqrt(beta),  predicted u_n + dt v_n + dt^2 (1/2 - beta) a_n,
///                   v = v_n + dt ((1 - gamma) a_n + gamma a)
///
/// and in all of them a = (u - predicted) / s^2. Held components have the velocity and acceleration
/// of their own motion instead: a scheme's would ring.
class TimeIntegrator {
 public:
  explicit TimeIntegrator(const IntegratorOptions &options) : options_(options) {}

  /// Goes on from a state, without those before it.
  void start(double time, Motion state);
  /// Goes on from a state and the one before.
  /// @param previous_step between the two; 0: there is none before
  void resume(double time, Motion state, Motion previous, double previous_step);

  /// Begins the step from time() on, or begins it anew with another length.
  const StepState &begin(double step, const HeldMotion &held);
  /// Ends it at the displacements u.
  void accept(const double *u);

  [[nodiscard]] double time() const { return time_; }
  [[nodiscard]] const Motion &state() const { return state_; }
  /// The state before it, without accelerations; empty where there is none.
  [[nodiscard]] const Motion &previous() const { return previous_; }
  [[nodiscard]] double previous_step() const { return previous_step_; }

 private:
  void extrapolate(double step);

  IntegratorOptions options_;
  double time_ = 0, previous_step_ = 0;
  Motion state_, previous_;
  StepState step_;
  std::vector<double> predicted_, velocity_origin_;
};

}  // namespace trefoil
