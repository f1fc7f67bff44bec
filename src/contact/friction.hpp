#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "contact/half_space.hpp"

namespace trefoil::contact {

/// The dissipated energy of sliding by y >= 0 under a force of 1, made smooth below e, and its
/// derivatives [Li et al. 2020, "Incremental potential contact", section 5]:
///     f0 = y^2/e (1 - y/(3e)) + e/3 below e, else y;  f1 = f0' = (2 - y/e) y/e, else 1.
struct Sliding {
  double f0 = 0, f1 = 0;
  double f1_over_y = 0;  ///< finite at y = 0
  double f2 = 0;         ///< f0'' = f1'
};
Sliding sliding(double y, double e);

/// One pair of the lagged friction D = sum mu lambda f0(|T'sum_i c_i (v_i - drift)|): the normal
/// force lambda, the weights c of the nearest points and the tangents T stay those of the last
/// converged state while v, the displacements since the begin of the step, changes. e is a length:
/// the slip velocity times the time of the step.
struct FrictionPair {
  std::array<int, 4> vertices{-1, -1, -1, -1};  ///< -1: none
  std::array<double, 4> weights{};
  std::array<Vector3, 2> tangents;  ///< orthonormal
  double force = 0;                 ///< mu lambda, N (in the plane N/m)
  Vector3 drift;                    ///< a half-space's own displacement since the begin of the step
};

/// mu between two bodies, by their numbers.
using FrictionOfBodies = std::function<double(int, int)>;

/// The pairs nearer than dhat at x, with lambda = kappa w m |b'|; those without friction left out.
std::vector<FrictionPair> lagged_friction(const Surface &surface, const ContactLaw &law,
                                          std::span<const ContactPair> pairs,
                                          std::span<const double> x, const FrictionOfBodies &mu);
/// The same for vertices against a half-space.
std::vector<FrictionPair> lagged_friction(const Surface &surface, const ContactLaw &law,
                                          const HalfSpace &plane, std::span<const int> vertices,
                                          std::span<const double> x, double mu);

/// D.
/// @param v  displacements since the begin of the step, 3 a vertex; those of moving obstacles too
double friction_energy(std::span<const FrictionPair> pairs, std::span<const double> v, double e);

/// Adds dD/dv, 3 a vertex.
void add_friction_gradient(std::span<const FrictionPair> pairs, std::span<const double> v, double e,
                           std::span<double> gradient);

/// One pair's Hessian: coordinate i of point a is row 3 a + i. It has no negative part: its
/// eigenvalues are f1/y, f1' >= 0 and zeros.
struct FrictionHessian {
  std::array<int, 4> vertices;
  std::array<double, 144> H;
};
void friction_hessians(std::span<const FrictionPair> pairs, std::span<const double> v, double e,
                       const std::function<void(const FrictionHessian &)> &take);

}  // namespace trefoil::contact
