#include "element/facet_rule.hpp"

#include <cmath>

#include "element/reference_element.hpp"

namespace trefoil {
namespace {

/// Edge on [0, 1]: corners first, then the middle.
void edge_functions(int nodes, double s, double *values, double (*gradients)[2]) {
  if (nodes == 2) {
    values[0] = 1 - s, values[1] = s;
    gradients[0][0] = -1, gradients[1][0] = 1;
    return;
  }
  values[0] = (1 - s) * (1 - 2 * s), values[1] = s * (2 * s - 1), values[2] = 4 * s * (1 - s);
  gradients[0][0] = 4 * s - 3, gradients[1][0] = 4 * s - 1, gradients[2][0] = 4 - 8 * s;
}

/// Two Gauss points for two nodes, three for three.
FacetRule make_edge(int nodes) {
  FacetRule rule{1, nodes, nodes, {}, {}, {}};
  const double offset = nodes == 2 ? std::sqrt(1. / 12) : std::sqrt(3. / 20);
  const double positions[3] = {0.5 - offset, 0.5 + offset, 0.5};
  for (int q = 0; q < rule.points; ++q) {
    rule.weights[q] = nodes == 2 ? 1. / 2 : (q == 2 ? 4. / 9 : 5. / 18);
    edge_functions(nodes, positions[q], rule.values[q], rule.gradients[q]);
  }
  return rule;
}

void add_triangle_point(double x, double y, double weight, FacetRule &rule) {
  const int q = rule.points++;
  const double position[3] = {x, y, 0};
  double gradients[FacetRule::most_nodes][3];
  shape_functions(2, rule.nodes, position, rule.values[q], gradients);
  for (int a = 0; a < rule.nodes; ++a) {
    for (int k = 0; k < 2; ++k) rule.gradients[q][a][k] = gradients[a][k];
  }
  rule.weights[q] = weight / 2;  // the reference triangle has area 1/2
}

/// Three points of equal weight for three nodes (degree 2), two times three for six (degree 4).
FacetRule make_triangle(int nodes) {
  FacetRule rule{2, nodes, 0, {}, {}, {}};
  const auto add_three = [&](double b, double weight) {
    const double a = 1 - 2 * b;
    add_triangle_point(b, b, weight, rule);
    add_triangle_point(a, b, weight, rule);
    add_triangle_point(b, a, weight, rule);
  };
  if (nodes == 3) {
    add_three(1. / 6, 1. / 3);
    return rule;
  }
  const double ten = std::sqrt(10.), place = std::sqrt(38 - 44 * std::sqrt(0.4)),
               weight = std::sqrt(213125 - 53320 * ten);
  add_three((8 - ten + place) / 18, (620 + weight) / 3720);
  add_three((8 - ten - place) / 18, (620 - weight) / 3720);
  return rule;
}

}  // namespace

const FacetRule &facet_rule(int dimension, int nodes) {
  static const FacetRule edges[] = {make_edge(2), make_edge(3)};
  static const FacetRule triangles[] = {make_triangle(3), make_triangle(6)};
  if (dimension == 1) return edges[nodes - 2];
  return triangles[nodes == 3 ? 0 : 1];
}

}  // namespace trefoil
