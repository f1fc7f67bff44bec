#include "time/integrator.hpp"

#include <cmath>
#include <utility>

namespace trefoil {

void TimeIntegrator::start(double time, Motion state) {
  resume(time, std::move(state), {}, 0);
}

void TimeIntegrator::resume(double time, Motion state, Motion previous, double previous_step) {
  time_ = time;
  state_ = std::move(state);
  previous_ = std::move(previous);
  previous_step_ = previous_step;
}

/// The step's energy, of all components as if they were free.
void TimeIntegrator::extrapolate(double dt) {
  const auto &[u, v, a] = state_;
  const std::size_t size = u.size();
  predicted_.resize(size);
  velocity_origin_.resize(size);
  if (options_.scheme == TimeScheme::newmark) {
    const double beta = options_.beta, gamma = options_.gamma;
    step_.inertia_time = dt * std::sqrt(beta);
    step_.velocity_time = beta * dt / gamma;
    for (std::size_t k = 0; k < size; ++k) {
      predicted_[k] = u[k] + dt * v[k] + dt * dt * (0.5 - beta) * a[k];
      velocity_origin_[k] = predicted_[k] - step_.velocity_time * (v[k] + dt * (1 - gamma) * a[k]);
    }
    return;
  }
  // Backward Euler is bdf2 without a state before, r = 0.
  const bool two_states = options_.scheme == TimeScheme::bdf2 && previous_step_ > 0;
  const double r = two_states ? dt / previous_step_ : 0;
  const double c = dt * (1 + r) / (1 + 2 * r);
  const double now = (1 + r) * (1 + r) / (1 + 2 * r), before = r * r / (1 + 2 * r);
  step_.inertia_time = step_.velocity_time = c;
  for (std::size_t k = 0; k < size; ++k) {
    const double u_before = two_states ? previous_.u[k] : 0,
                 v_before = two_states ? previous_.v[k] : 0;
    velocity_origin_[k] = now * u[k] - before * u_before;
    predicted_[k] = velocity_origin_[k] + c * (now * v[k] - before * v_before);
  }
}

const StepState &TimeIntegrator::begin(double step, const HeldMotion &held) {
  step_.step = step;
  step_.time = time_ + step;
  extrapolate(step);
  const auto &[u, v, a] = held.at_end;
  for (std::size_t k = 0; k < held.held.size(); ++k) {
    if (!held.held[k]) continue;
    predicted_[k] = u[k] - step_.inertia_time * step_.inertia_time * a[k];
    velocity_origin_[k] = u[k] - step_.velocity_time * v[k];
  }
  step_.predicted = predicted_.data();
  step_.velocity_origin = velocity_origin_.data();
  return step_;
}

void TimeIntegrator::accept(const double *u) {
  const double c = step_.velocity_time, s2 = step_.inertia_time * step_.inertia_time;
  std::swap(previous_, state_);
  const std::size_t size = predicted_.size();
  for (auto *values : {&state_.u, &state_.v, &state_.a}) values->resize(size);
  for (std::size_t k = 0; k < size; ++k) {
    state_.u[k] = u[k];
    state_.v[k] = (u[k] - velocity_origin_[k]) / c;
    state_.a[k] = (u[k] - predicted_[k]) / s2;
  }
  previous_step_ = step_.step;
  time_ = step_.time;
}

}  // namespace trefoil
