#include "contact/friction.hpp"

#include "contact/pair_derivatives.hpp"

namespace trefoil::contact {
namespace {

/// Two directions orthogonal to a unit normal and to each other; for a normal in the plane the
/// second one is z.
std::array<Vector3, 2> tangents_of(const Vector3 &normal) {
  const Vector3 helper = std::abs(normal.z) < 0.9 ? Vector3{0, 0, 1} : Vector3{1, 0, 0};
  Vector3 first = cross(helper, normal);
  first = (1 / norm(first)) * first;
  return {first, cross(normal, first)};
}

/// y = T'sum_i c_i (v_i - drift), the drift with the weight of the vertices that there are.
std::array<double, 2> slip(const FrictionPair &pair, std::span<const double> v) {
  Vector3 relative;
  for (int a = 0; a < 4; ++a) {
    if (pair.vertices[a] < 0) continue;
    relative = relative + pair.weights[a] * (point_of(v, pair.vertices[a]) - pair.drift);
  }
  return {dot(pair.tangents[0], relative), dot(pair.tangents[1], relative)};
}

double length_of(const std::array<double, 2> &y) {
  return std::sqrt(y[0] * y[0] + y[1] * y[1]);
}

/// force times f1/|y| I + (f1' - f1/|y|) y y'/|y|^2, with the direction y/|y| at rest of no
/// meaning.
std::array<double, 4> tangent_hessian(const FrictionPair &pair, const std::array<double, 2> &y,
                                      double e) {
  const double length = length_of(y);
  const Sliding f = sliding(length, e);
  const double round = pair.force * f.f1_over_y, along = pair.force * (f.f2 - f.f1_over_y);
  const double c = length > 0 ? y[0] / length : 0, s = length > 0 ? y[1] / length : 0;
  return {round + along * c * c, along * c * s, along * c * s, round + along * s * s};
}

}  // namespace

Sliding sliding(double y, double e) {
  if (y >= e) return {y, 1, 1 / y, 0};
  const double s = y / e;
  return {y * s * (1 - s / 3) + e / 3, (2 - s) * s, (2 - s) / e, 2 * (1 - s) / e};
}

std::vector<FrictionPair> lagged_friction(const Surface &surface, const ContactLaw &law,
                                          std::span<const ContactPair> pairs,
                                          std::span<const double> x, const FrictionOfBodies &mu) {
  std::vector<FrictionPair> lagged;
  for (const ContactPair &pair : pairs) {
    const double coefficient = mu(first_of(surface, pair).body, second_of(surface, pair).body);
    if (!(coefficient > 0)) continue;
    const auto vertices = vertices_of(surface, pair);
    const PairPoints points = points_of(vertices, x);
    const NearestPoints nearest = nearest_points(pair.kind, points);
    if (!(nearest.distance < law.distance)) continue;
    const double lambda = pair_force(surface, law, pair, points, nearest.distance);
    lagged.push_back(
        {vertices, nearest.weights, tangents_of(nearest.normal), coefficient * lambda, {}});
  }
  return lagged;
}

std::vector<FrictionPair> lagged_friction(const Surface &surface, const ContactLaw &law,
                                          const HalfSpace &plane, std::span<const int> vertices,
                                          std::span<const double> x, double mu) {
  std::vector<FrictionPair> lagged;
  for (const int vertex : vertices) {
    const double gap = plane.gap(point_of(x, vertex));
    if (!(mu > 0) || !(gap < law.distance)) continue;
    const Primitive &data = surface.vertex_data[vertex];
    const double lambda =
        -law.stiffening * data.stiffness * data.area * barrier(gap, law.distance).first;
    lagged.push_back(
        {{vertex, -1, -1, -1}, {1, 0, 0, 0}, tangents_of(plane.normal), mu * lambda, {}});
  }
  return lagged;
}

double friction_energy(std::span<const FrictionPair> pairs, std::span<const double> v, double e) {
  double energy = 0;
  for (const FrictionPair &pair : pairs) {
    energy += pair.force * sliding(length_of(slip(pair, v)), e).f0;
  }
  return energy;
}

void add_friction_gradient(std::span<const FrictionPair> pairs, std::span<const double> v, double e,
                           std::span<double> gradient) {
  for (const FrictionPair &pair : pairs) {
    const auto y = slip(pair, v);
    const double factor = pair.force * sliding(length_of(y), e).f1_over_y;
    const Vector3 force = (factor * y[0]) * pair.tangents[0] + (factor * y[1]) * pair.tangents[1];
    for (int a = 0; a < 4; ++a) {
      if (pair.vertices[a] < 0) continue;
      for (int i = 0; i < 3; ++i) {
        gradient[3 * static_cast<std::size_t>(pair.vertices[a]) + i] += pair.weights[a] * force[i];
      }
    }
  }
}

void friction_hessians(std::span<const FrictionPair> pairs, std::span<const double> v, double e,
                       const std::function<void(const FrictionHessian &)> &take) {
  FrictionHessian result;
  for (const FrictionPair &pair : pairs) {
    const auto S = tangent_hessian(pair, slip(pair, v), e);
    const auto &[t, s] = pair.tangents;
    double block[3][3];
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        block[i][j] = S[0] * t[i] * t[j] + S[1] * (t[i] * s[j] + s[i] * t[j]) + S[3] * s[i] * s[j];
      }
    }
    result.vertices = pair.vertices;
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        const double weight = pair.weights[a] * pair.weights[b];
        for (int i = 0; i < 3; ++i) {
          for (int j = 0; j < 3; ++j) {
            result.H[12 * (3 * a + i) + 3 * b + j] = weight * block[i][j];
          }
        }
      }
    }
    take(result);
  }
}

}  // namespace trefoil::contact
