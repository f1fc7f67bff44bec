// The schemes of time on springs and masses that are solved in closed form: their recursions, their
// orders, steps of changing length, and prescribed components.

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <vector>

#include "time/integrator.hpp"

namespace trefoil {
namespace {

constexpr double omega = 3;

const HeldMotion nothing_is_held{
    {0, 0, 0}, {std::vector<double>(3), std::vector<double>(3), std::vector<double>(3)}};

/// Ends a step of three oscillators of mass 1 and stiffness omega^2: the minimum of
/// |u - predicted|^2 / (2 s^2) + omega^2 |u|^2 / 2 and, with damping alpha, of
/// alpha |u - velocity_origin|^2 / (2 c).
void take_step(TimeIntegrator &integrator, double dt, double alpha = 0, double force = 0) {
  const StepState &step = integrator.begin(dt, nothing_is_held);
  const double inertia = 1 / (step.inertia_time * step.inertia_time);
  double u[3];
  for (int i = 0; i < 3; ++i) {
    u[i] = (inertia * step.predicted[i] + alpha / step.velocity_time * step.velocity_origin[i] +
            force) /
           (inertia + alpha / step.velocity_time + omega * omega);
  }
  integrator.accept(u);
}

Motion oscillating(double u, double v) {
  return {{u, 0, 0}, {v, 0, 0}, {-omega * omega * u, 0, 0}};
}

const IntegratorOptions backward_euler{TimeScheme::backward_euler}, bdf2{TimeScheme::bdf2},
    newmark{TimeScheme::newmark};

/// The error at time 1 of cos(omega t), in n steps, of which those of the second half are half as
/// long.
double error_in(const IntegratorOptions &options, int n) {
  TimeIntegrator integrator(options);
  integrator.start(0, oscillating(1, 0));
  const double dt = 1. / n;
  for (int k = 0; k < n / 2; ++k) take_step(integrator, dt);
  for (int k = 0; k < n; ++k) take_step(integrator, dt / 2);
  EXPECT_NEAR(integrator.time(), 1, 1e-12);
  return std::hypot(integrator.state().u[0] - std::cos(omega),
                    (integrator.state().v[0] + omega * std::sin(omega)) / omega);
}

TEST(TimeIntegratorTest, OrdersAreOneTwoTwo) {
  const std::pair<IntegratorOptions, double> orders[] = {
      {backward_euler, 1}, {bdf2, 2}, {newmark, 2}};
  for (const auto &[options, order] : orders) {
    const double ratio = error_in(options, 400) / error_in(options, 800);
    EXPECT_NEAR(std::log2(ratio), order, 0.03);
  }
}

/// z = u + i v / omega: each step multiplies it by a number.
TEST(TimeIntegratorTest, AmplitudesFollowTheScheme) {
  constexpr double dt = 0.11;
  const auto factor = [](const IntegratorOptions &options, double scale_v) {
    TimeIntegrator integrator(options);
    integrator.start(0, oscillating(0.6, 0.8 * omega));
    const std::complex<double> before(0.6, 0.8);
    take_step(integrator, dt);
    const Motion &end = integrator.state();
    EXPECT_NEAR(end.a[0], -omega * omega * end.u[0], 1e-12) << "equation of motion";
    return std::complex<double>(end.u[0], scale_v * end.v[0] / omega) / before;
  };
  const std::complex<double> euler = factor(backward_euler, 1);
  EXPECT_NEAR(std::abs(euler), 1 / std::sqrt(1 + omega * omega * dt * dt), 1e-14);
  EXPECT_NEAR(std::abs(std::arg(euler)), std::atan(omega * dt), 1e-14);
  const std::complex<double> average = factor(newmark, 1);
  EXPECT_NEAR(std::abs(average), 1, 1e-14);
  EXPECT_NEAR(std::abs(std::arg(average)), 2 * std::atan(omega * dt / 2), 1e-14);
}

/// With equal steps the weights are 4/3, -1/3, 2/3.
TEST(TimeIntegratorTest, Bdf2HasItsWeights) {
  TimeIntegrator integrator(bdf2);
  integrator.resume(0.5, {{2, 0, 0}, {3, 0, 0}, {0, 0, 0}}, {{1, 0, 0}, {5, 0, 0}, {}}, 0.1);
  const StepState &step = integrator.begin(0.1, nothing_is_held);
  EXPECT_NEAR(step.inertia_time, 2. / 3 * 0.1, 1e-16);
  EXPECT_NEAR(step.velocity_origin[0], 4. / 3 * 2 - 1. / 3, 1e-15);
  EXPECT_NEAR(step.predicted[0],
              step.velocity_origin[0] + step.inertia_time * (4. / 3 * 3 - 5. / 3), 1e-15);
  EXPECT_NEAR(step.time, 0.6, 1e-16);
}

/// A constant force on a free mass: u is that of the scheme's sum, and Newmark's that of nature.
TEST(TimeIntegratorTest, FreeFall) {
  constexpr double g = -9.81, v0 = 2, dt = 0.03;
  constexpr int steps = 40;
  const auto fall = [&](const IntegratorOptions &options) {
    TimeIntegrator integrator(options);
    integrator.start(0, {{0, 0, 0}, {v0, 0, 0}, {g, 0, 0}});
    for (int n = 0; n < steps; ++n) {
      const StepState &step = integrator.begin(dt, nothing_is_held);
      const double s2 = step.inertia_time * step.inertia_time;
      const double u[3] = {step.predicted[0] + s2 * g, 0, 0};
      integrator.accept(u);
    }
    return integrator.state();
  };
  const double t = steps * dt;
  EXPECT_NEAR(fall(backward_euler).u[0], v0 * t + 0.5 * g * dt * dt * steps * (steps + 1), 1e-12);
  EXPECT_NEAR(fall(newmark).u[0], v0 * t + 0.5 * g * t * t, 1e-12);
  EXPECT_NEAR(fall(bdf2).v[0], v0 + g * t, 1e-12);
}

/// Damping in proportion to mass: half of alpha is the rate of decay, the log decrement over omega.
TEST(TimeIntegratorTest, DampingHasItsDecrement) {
  constexpr double alpha = 0.2, dt = 1e-3;
  TimeIntegrator integrator(newmark);
  Motion start = oscillating(1, 0);
  start.a[0] -= alpha * start.v[0];
  integrator.start(0, start);
  for (int n = 0; n < 5000; ++n) take_step(integrator, dt, alpha);
  const double t = 5, rate = alpha / 2, damped = std::sqrt(omega * omega - rate * rate);
  EXPECT_NEAR(integrator.state().u[0],
              std::exp(-rate * t) * (std::cos(damped * t) + rate / damped * std::sin(damped * t)),
              3e-5);
}

/// What is held goes where it is told, with the velocity and acceleration that it is told.
TEST(TimeIntegratorTest, HeldComponentsMoveAsTheyAreTold) {
  for (const IntegratorOptions &options : {backward_euler, bdf2, newmark}) {
    TimeIntegrator integrator(options);
    integrator.start(0, oscillating(0, 17));  // nothing of the start rings
    double t = 0;
    for (const double dt : {0.1, 0.1, 0.05, 0.2}) {
      t += dt;
      const HeldMotion held{{1, 0, 0},
                            {{std::sin(t), 0, 0}, {std::cos(t), 0, 0}, {-std::sin(t), 0, 0}}};
      integrator.begin(dt, held);
      const double u[3] = {std::sin(t), 0, 0};
      integrator.accept(u);
      EXPECT_NEAR(integrator.state().v[0], std::cos(t), 1e-14);
      EXPECT_NEAR(integrator.state().a[0], -std::sin(t), 1e-12);
    }
  }
}

/// A step that failed is begun anew with another length.
TEST(TimeIntegratorTest, AStepMayBeBegunAnew) {
  for (const IntegratorOptions &options : {backward_euler, bdf2, newmark}) {
    TimeIntegrator one(options), other(options);
    for (TimeIntegrator *each : {&one, &other}) {
      each->start(0, oscillating(1, 0.3));
      take_step(*each, 0.1);
    }
    other.begin(0.1, nothing_is_held);
    take_step(one, 0.05);
    take_step(other, 0.05);
    EXPECT_EQ(one.state().u, other.state().u);
    EXPECT_EQ(one.state().v, other.state().v);
    EXPECT_EQ(one.time(), other.time());
  }
}

}  // namespace
}  // namespace trefoil
