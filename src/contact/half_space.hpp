#pragma once

#include <span>
#include <vector>

#include "contact/additive_ccd.hpp"

#include "contact/contact_energy.hpp"

namespace trefoil::contact {

/// An obstacle without a mesh: vertices keep to the side normal'x >= offset. Its contact energy is
/// the sum over vertices of kappa w b(normal'x - offset), with all of a vertex's area w.
struct HalfSpace {
  Vector3 normal;  ///< unit
  double offset = 0;

  [[nodiscard]] double gap(const Vector3 &x) const { return dot(normal, x) - offset; }
};

/// The functions of contact_energy.hpp for some vertices, those of this rank, against a half-space.
double half_space_energy(const Surface &surface, const ContactLaw &law, const HalfSpace &plane,
                         std::span<const int> vertices, std::span<const double> x);
void add_half_space_gradient(const Surface &surface, const ContactLaw &law, const HalfSpace &plane,
                             std::span<const int> vertices, std::span<const double> x,
                             std::span<double> gradient);

/// Calls take(vertex, curvature) for each vertex nearer than dhat: its Hessian is curvature times
/// normal normal', with curvature >= 0, and has no negative part.
void half_space_hessians(const Surface &surface, const ContactLaw &law, const HalfSpace &plane,
                         std::span<const int> vertices, std::span<const double> x,
                         const std::function<void(int vertex, double curvature)> &take);

/// The least gap, and the place of its vertex in `vertices`.
LeastGap least_gap(const HalfSpace &plane, std::span<const int> vertices,
                   std::span<const double> x);

/// The largest t <= 1 for which all vertices, moving to x + t step, keep limits.least(gap) to the
/// plane while that moves from `plane` to `moved_plane` without turning; `pair` is a place in
/// `vertices`.
AllowedStep allowed_step(const HalfSpace &plane, const HalfSpace &moved_plane,
                         std::span<const int> vertices, std::span<const double> x,
                         std::span<const double> step, const StepLimits &limits);

}  // namespace trefoil::contact
