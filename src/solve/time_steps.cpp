#include "solve/time_steps.hpp"

#include <algorithm>
#include <cmath>

namespace trefoil {
namespace {

constexpr double crumb = 1e-9;  // of a full step: what only rounding makes

}  // namespace

void TimeSteps::go_on(const Reached &reached) {
  time_ = reached.time;
  step_ = std::min(reached.step, full_);
  accepted_ = reached.accepted;
  was_halved_ = reached.was_halved;
}

double TimeSteps::next() const {
  const double time = time_ + step_, whole = full_ * std::round(time / full_);
  if (time > end_ - crumb * full_) return end_;
  return std::abs(time - whole) < crumb * full_ ? whole : time;
}

double TimeSteps::length() const {
  const double left = end_ - time_;
  return left < step_ - crumb * full_ ? left : step_;
}

void TimeSteps::accept() {
  constexpr double growth = 1.25;
  time_ = next();
  ++accepted_;
  if (!was_halved_) step_ = std::min(growth * step_, full_);
  was_halved_ = false;
}

bool TimeSteps::halve() {
  const double half = length() / 2;
  if (half < least_ * (1 - crumb)) return false;
  step_ = half;
  was_halved_ = true;
  return true;
}

}  // namespace trefoil
