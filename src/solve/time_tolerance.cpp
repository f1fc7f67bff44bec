#include "solve/time_tolerance.hpp"

#include <algorithm>
#include <sstream>

namespace trefoil {
namespace {

/// Directions end no step where they are longer, however long the step is: as a share of the box's
/// diagonal. A velocity times a long step would be no tolerance at all.
constexpr double longest_tolerated = 1e-3;

/// Friction holds by slips of less than its slip velocity: the solver must resolve those, or it
/// ends at rest where bodies slide.
constexpr double share_of_slip = 0.03;

}  // namespace

TimeTolerance::TimeTolerance(const Scene &scene)
    : options_(scene.options.time),
      diagonal_(box_of(scene.mesh).diagonal()),
      asked_(options_.tolerated_velocity(diagonal_)),
      velocity_(asked_) {
  if (scene.contact && scene.contact->has_friction()) {
    velocity_ = std::min(asked_, share_of_slip * scene.contact->parameters().slip_velocity);
  }
}

double TimeTolerance::of_step(double length) const {
  return std::min(velocity_ * length, longest_tolerated * diagonal_);
}

std::string TimeTolerance::text() const {
  if (velocity_ <= 0) return "a step in time ends by its energy alone: the velocity tolerance is 0";
  std::ostringstream text;
  text << "a step in time ends where the direction over its length is below " << velocity_;
  if (velocity_ < asked_) {
    text << " (a share of -contact_slip_velocity, which friction needs)";
  } else if (options_.absolute_velocity_tolerance) {
    text << " (-time_velocity_tolerance_absolute, in length per time)";
  } else {
    text << " (-time_velocity_tolerance, " << options_.velocity_tolerance
         << " of the box's diagonal per time)";
  }
  if (velocity_ * *options_.step > longest_tolerated * diagonal_) {
    text << ", and the direction itself below " << longest_tolerated * diagonal_ << " ("
         << longest_tolerated << " of the diagonal): the steps are long";
  }
  return text.str();
}

}  // namespace trefoil
