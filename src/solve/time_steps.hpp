#pragma once

#include "solve/step_sizes.hpp"

namespace trefoil {

/// How the way from t = 0 to an end is cut into steps in time: of one length, which is halved where
/// a step fails, and grows again by a quarter a step. Says when; who walks it says how it went.
class TimeSteps {
 public:
  /// @param step the longest; @param least below which none is halved; all in units of time
  TimeSteps(double end, double step, double least) : end_(end), full_(step), least_(least) {}

  [[nodiscard]] bool is_done() const { return time_ >= end_; }
  /// Where the next step leads: multiples of the full step, and the end, exactly.
  [[nodiscard]] double next() const;
  /// Its length, free of the rounding of next() - time().
  [[nodiscard]] double length() const;
  /// The step stands.
  void accept();
  /// The step failed. @return whether a shorter one is left to be tried, which next() then says
  bool halve();

  /// Where the way has led so far.
  using Reached = StepSizes::Reached;
  [[nodiscard]] Reached reached() const { return {time_, step_, accepted_, was_halved_}; }
  /// Goes on from there; its steps may be those of another length of the full one.
  void go_on(const Reached &reached);

  [[nodiscard]] double time() const { return time_; }  ///< where the last step led that stands
  [[nodiscard]] int accepted() const { return accepted_; }

 private:
  double end_, full_, least_;
  double time_ = 0, step_ = full_;
  int accepted_ = 0;
  bool was_halved_ = false;  ///< since the last step that stands
};

}  // namespace trefoil
