#pragma once

#include <string>
#include <vector>

#include "rule/iteration_record.hpp"
#include "support/phase_clock.hpp"

namespace trefoil {

/// What the unfiltered Hessian says of the point where a solve ended.
enum class StationaryPoint { unknown, minimum, saddle };

/// What is known of a running or finished solve: its iterations, and what sums them up. Monitor,
/// stop test and JSON record read nothing else.
struct SolveRecord {
  bool running = false;  ///< between the start of a solve and its end
  PhaseClock clock;
  double head_start = 0;    ///< seconds spent on a starting guess: history counts them
  IterationRecord current;  ///< the iteration under way
  std::vector<IterationRecord> history;

  bool converged = false;
  std::string reason;  ///< why the solve ended, one phrase for people
  double energy_scale = IterationRecord::none;
  int iterations = 0;         ///< Jacobians that were solved with
  int linear_solves = 0;      ///< those of Shamanskii steps included
  int krylov_iterations = 0;  ///< of all linear solves, Shamanskii steps' included
  int factorisations = 0;     ///< set-ups of the preconditioner, those of refused Jacobians as well
  StationaryPoint end = StationaryPoint::unknown;
  int saddles_left = 0;  ///< along negative curvature, after the stop test was met
  /// g'H^-1 g / 2 at the end, with the unfiltered Hessian: how far above its minimum the energy
  /// still is, to second order. Not-a-number where nobody has factored H.
  double error_estimate = IterationRecord::none;
  /// |H d + g| / |g| of the direction that met the stop test; not-a-number where none did.
  double linear_residual = IterationRecord::none;
  std::vector<std::string> notes;  ///< what the user should know of this solve, a sentence each
  int verification_solves = 0;     ///< with the factors of the last Jacobian, to look for it

  /// Begins a new solve: forgets the last one and starts the clock.
  void begin();
  /// Since the solve began, with the head start.
  [[nodiscard]] double seconds() const { return head_start + clock.elapsed(); }
  /// The last iteration whose step a rule may learn from; null where there is none yet.
  [[nodiscard]] const IterationRecord *last_lesson() const;
};

}  // namespace trefoil
