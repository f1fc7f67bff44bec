#include "element/mass_matrix.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace trefoil {
namespace {

constexpr int most_nodes = ReferenceElement::most_nodes;

/// A point of quadrature on the reference cell.
struct MassPoint {
  double weight = 0;
  double values[most_nodes];
  double gradients[most_nodes][3];
};

/// The rule of Gauss and Legendre with five points on [0, 1]: exact for polynomials of degree 9.
struct GaussLegendre {
  static constexpr int points = 5;
  double position[points], weight[points];

  GaussLegendre() {
    const double root = 2 * std::sqrt(10. / 7), far = std::sqrt(5 + root) / 3,
                 near = std::sqrt(5 - root) / 3;
    const double outer = (322 - 13 * std::sqrt(70.)) / 900,
                 inner = (322 + 13 * std::sqrt(70.)) / 900;
    const double places[points] = {-far, -near, 0, near, far};
    const double weights[points] = {outer, inner, 128. / 225, inner, outer};
    for (int k = 0; k < points; ++k) {
      position[k] = 0.5 * (1 + places[k]);
      weight[k] = 0.5 * weights[k];
    }
  }
};

/// The simplex as a cube of which sides are collapsed: x = r (1 - s) (1 - t), y = s (1 - t), z = t.
/// The integrand, at most of degree 4 in the shape functions and 3 in the Jacobian determinant of a
/// bent element, and the map's determinant, at most of degree 2, are together of degree 9.
std::vector<MassPoint> make_rule(const ReferenceElement &reference) {
  const GaussLegendre line;
  const int layers = reference.dimension == 3 ? GaussLegendre::points : 1;
  std::vector<MassPoint> rule;
  for (int i = 0; i < GaussLegendre::points; ++i) {
    for (int j = 0; j < GaussLegendre::points; ++j) {
      for (int k = 0; k < layers; ++k) {
        const double t = layers > 1 ? line.position[k] : 0, s = line.position[j];
        const double position[3] = {line.position[i] * (1 - s) * (1 - t), s * (1 - t), t};
        MassPoint point;
        point.weight = line.weight[i] * line.weight[j] * (1 - s);
        if (layers > 1) point.weight *= line.weight[k] * (1 - t) * (1 - t);
        shape_functions(reference.dimension, reference.nodes, position, point.values,
                        point.gradients);
        rule.push_back(point);
      }
    }
  }
  return rule;
}

const std::vector<MassPoint> &rule_of(const ReferenceElement &reference) {
  static const std::vector<MassPoint> rules[] = {
      make_rule(reference_element(2, 3)), make_rule(reference_element(2, 6)),
      make_rule(reference_element(3, 4)), make_rule(reference_element(3, 10))};
  const bool linear = reference.nodes == reference.dimension + 1;
  return rules[2 * (reference.dimension - 2) + (linear ? 0 : 1)];
}

double jacobian_determinant(const ReferenceElement &reference, const MassPoint &point,
                            const double *positions) {
  double J[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < reference.dimension; ++i) {
    for (int j = 0; j < reference.dimension; ++j) {
      J[i][j] = 0;
      for (int a = 0; a < reference.nodes; ++a) {
        J[i][j] += positions[3 * a + i] * point.gradients[a][j];
      }
    }
  }
  return J[0][0] * (J[1][1] * J[2][2] - J[1][2] * J[2][1]) -
         J[0][1] * (J[1][0] * J[2][2] - J[1][2] * J[2][0]) +
         J[0][2] * (J[1][0] * J[2][1] - J[1][1] * J[2][0]);
}

void integrate(const ReferenceElement &reference, const double *positions, double *M) {
  const int nodes = reference.nodes;
  std::fill_n(M, nodes * nodes, 0);
  for (const MassPoint &point : rule_of(reference)) {
    const double weight = point.weight * jacobian_determinant(reference, point, positions);
    for (int a = 0; a < nodes; ++a) {
      for (int b = 0; b <= a; ++b) M[nodes * a + b] += weight * point.values[a] * point.values[b];
    }
  }
  for (int a = 0; a < nodes; ++a) {
    for (int b = 0; b < a; ++b) M[nodes * b + a] = M[nodes * a + b];
  }
}

/// Closed form for constant Jacobians: V (1 + delta_ab) / ((d + 1) (d + 2)).
void linear_mass_matrix(const ReferenceElement &reference, const double *positions, double *M) {
  const int nodes = reference.nodes;
  const double volume =
      reference.volume * jacobian_determinant(reference, rule_of(reference).front(), positions);
  for (int a = 0; a < nodes; ++a) {
    for (int b = 0; b < nodes; ++b) {
      M[nodes * a + b] = (a == b ? 2 : 1) * volume / (nodes * (nodes + 1));
    }
  }
}

}  // namespace

void mass_matrix(const ReferenceElement &reference, const double *positions, double *M) {
  const bool linear = reference.nodes == reference.dimension + 1;
  (linear ? linear_mass_matrix : integrate)(reference, positions, M);
}

}  // namespace trefoil
