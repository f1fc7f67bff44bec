#include "element/reference_element.hpp"

#include <cmath>

namespace trefoil {
namespace {

constexpr int edges[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

ReferenceElement make(const char *name, int dimension, int nodes) {
  ReferenceElement element{};
  element.name = name;
  element.dimension = dimension;
  element.nodes = nodes;
  element.volume = dimension == 2 ? 1. / 2 : 1. / 6;
  const bool linear = nodes == dimension + 1;
  element.points = linear ? 1 : dimension + 1;
  // Degree 2 with dimension + 1 points, each near a corner: barycentric coordinate `near` for that
  // corner, the same for the others [Hammer, Stroud 1956].
  const double near = dimension == 2 ? 2. / 3 : (5 + 3 * std::sqrt(5.)) / 20;
  const double far = (1 - near) / dimension;
  for (int q = 0; q < element.points; ++q) {
    for (int i = 0; i < dimension; ++i) {
      element.position[q][i] = linear ? 1. / (dimension + 1) : i + 1 == q ? near : far;
    }
    shape_functions(dimension, nodes, element.position[q], element.values[q], element.gradients[q]);
  }
  return element;
}

}  // namespace

void shape_functions(int dimension, int nodes, const double *position, double *values,
                     double (*gradients)[3]) {
  // Barycentric coordinates: the linear shape functions.
  double L[4] = {1, 0, 0, 0}, dL[4][3] = {};
  const int corners = dimension + 1;
  for (int i = 0; i < dimension; ++i) {
    L[0] -= position[i];
    L[i + 1] = position[i];
    dL[0][i] = -1;
    dL[i + 1][i] = 1;
  }
  for (int a = 0; a < corners; ++a) {
    const bool linear = nodes == corners;
    values[a] = linear ? L[a] : L[a] * (2 * L[a] - 1);
    for (int i = 0; i < dimension; ++i) {
      gradients[a][i] = linear ? dL[a][i] : (4 * L[a] - 1) * dL[a][i];
    }
  }
  for (int e = 0; corners + e < nodes; ++e) {
    const int a = edges[e][0], b = edges[e][1];
    values[corners + e] = 4 * L[a] * L[b];
    for (int i = 0; i < dimension; ++i) {
      gradients[corners + e][i] = 4 * (L[a] * dL[b][i] + L[b] * dL[a][i]);
    }
  }
}

const ReferenceElement &reference_element(int dimension, int nodes) {
  static const ReferenceElement tri3 = make("tri3", 2, 3), tri6 = make("tri6", 2, 6),
                                tet4 = make("tet4", 3, 4), tet10 = make("tet10", 3, 10);
  if (dimension == 2) return nodes == 3 ? tri3 : tri6;
  return nodes == 4 ? tet4 : tet10;
}

}  // namespace trefoil
