#pragma once

#include <petsctime.h>

#include <array>
#include <cstddef>

namespace trefoil {

/// What a solve spends its time on.
enum class Phase : std::size_t { assembly, filter, linear_solve, line_search, other };
inline constexpr std::size_t phase_count = 5;

/// A stop-watch with one hand: at any moment exactly one phase runs, so phases are disjoint and
/// their sum is the time since start().
class PhaseClock {
 public:
  void start(Phase phase) {
    seconds_.fill(0);
    running_ = phase;
    PetscTime(&begin_);
    last_ = begin_;
  }

  /// Goes over to `phase`; returns the one that ran until now.
  Phase switch_to(Phase phase) {
    PetscLogDouble now = 0;
    PetscTime(&now);
    seconds_[static_cast<std::size_t>(running_)] += now - last_;
    last_ = now;
    const Phase previous = running_;
    running_ = phase;
    return previous;
  }

  /// Books seconds that were measured inside one phase to another one.
  void move(Phase from, Phase to, double seconds) {
    seconds_[static_cast<std::size_t>(from)] -= seconds;
    seconds_[static_cast<std::size_t>(to)] += seconds;
  }

  [[nodiscard]] double seconds(Phase phase) const {
    return seconds_[static_cast<std::size_t>(phase)];
  }

  /// Since start().
  [[nodiscard]] double elapsed() const {
    PetscLogDouble now = 0;
    PetscTime(&now);
    return now - begin_;
  }

 private:
  std::array<double, phase_count> seconds_{};
  Phase running_ = Phase::other;
  PetscLogDouble begin_ = 0, last_ = 0;
};

}  // namespace trefoil
