#include "solve/step_sizes.hpp"

#include <algorithm>

namespace trefoil {

StepSizes StepSizes::equal(int count) {
  return {count, 1. / count, 1. / count};
}

StepSizes StepSizes::adaptive(double first, double least) {
  return {0, std::min(first, 1.), least};
}

void StepSizes::go_on(const Reached &reached) {
  time_ = reached.time;
  step_ = reached.step;
  accepted_ = reached.accepted;
  was_halved_ = reached.was_halved;
}

double StepSizes::next() const {
  constexpr double crumb = 1e-9;  // no last step that only rounding makes
  if (count_ > 0) return accepted_ + 1 == count_ ? 1 : static_cast<double>(accepted_ + 1) / count_;
  return time_ + step_ > 1 - crumb ? 1 : time_ + step_;
}

void StepSizes::accept(bool was_easy) {
  time_ = next();
  ++accepted_;
  // A step that had to be halved is followed by one of its own length.
  if (count_ == 0 && was_easy && !was_halved_) step_ *= 2;
  was_halved_ = false;
}

bool StepSizes::can_halve() const {
  return count_ == 0 && (next() - time_) / 2 >= least_;
}

bool StepSizes::halve() {
  if (!can_halve()) return false;
  step_ = (next() - time_) / 2;
  was_halved_ = true;
  return true;
}

}  // namespace trefoil
