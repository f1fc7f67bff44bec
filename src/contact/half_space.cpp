#include "contact/half_space.hpp"

#include "contact/barrier.hpp"

namespace trefoil::contact {
namespace {

double vertex_stiffness(const Surface &surface, const ContactLaw &law, int vertex) {
  const Primitive &data = surface.vertex_data[vertex];
  return law.stiffening * data.stiffness * data.area;
}

/// Calls f(vertex, gap) for the vertices nearer than dhat.
template <class Function>
void for_near_vertices(const ContactLaw &law, const HalfSpace &plane, std::span<const int> vertices,
                       std::span<const double> x, const Function &f) {
  for (const int vertex : vertices) {
    const double gap = plane.gap(point_of(x, vertex));
    if (!(gap >= law.distance)) f(vertex, gap);
  }
}

}  // namespace

double half_space_energy(const Surface &surface, const ContactLaw &law, const HalfSpace &plane,
                         std::span<const int> vertices, std::span<const double> x) {
  double energy = 0;
  for_near_vertices(law, plane, vertices, x, [&](int vertex, double gap) {
    energy += vertex_stiffness(surface, law, vertex) * barrier_value(gap, law.distance);
  });
  return energy;
}

void add_half_space_gradient(const Surface &surface, const ContactLaw &law, const HalfSpace &plane,
                             std::span<const int> vertices, std::span<const double> x,
                             std::span<double> gradient) {
  for_near_vertices(law, plane, vertices, x, [&](int vertex, double gap) {
    const double slope = vertex_stiffness(surface, law, vertex) * barrier(gap, law.distance).first;
    for (int i = 0; i < 3; ++i) {
      gradient[3 * static_cast<std::size_t>(vertex) + i] += slope * plane.normal[i];
    }
  });
}

void half_space_hessians(const Surface &surface, const ContactLaw &law, const HalfSpace &plane,
                         std::span<const int> vertices, std::span<const double> x,
                         const std::function<void(int vertex, double curvature)> &take) {
  for_near_vertices(law, plane, vertices, x, [&](int vertex, double gap) {
    take(vertex, vertex_stiffness(surface, law, vertex) * barrier(gap, law.distance).second);
  });
}

LeastGap least_gap(const HalfSpace &plane, std::span<const int> vertices,
                   std::span<const double> x) {
  LeastGap least;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const double gap = plane.gap(point_of(x, vertices[k]));
    if (gap < least.gap) least = {gap, static_cast<int>(k)};
  }
  return least;
}

AllowedStep allowed_step(const HalfSpace &plane, const HalfSpace &moved_plane,
                         std::span<const int> vertices, std::span<const double> x,
                         std::span<const double> step, const StepLimits &limits) {
  AllowedStep allowed;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const Vector3 from = point_of(x, vertices[k]);
    const double start = plane.gap(from);
    const double closing =
        moved_plane.offset - plane.offset - dot(plane.normal, point_of(step, vertices[k]));
    if (closing <= 0) continue;
    const double room = start > limits.touching ? start - limits.least(start) : 0;
    const double t = room / closing;
    if (t < allowed.step) allowed = {t, static_cast<int>(k)};
  }
  return allowed;
}

}  // namespace trefoil::contact
