#include "term/facet_points.hpp"

#include <cmath>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Vector = std::array<double, 3>;

Vector cross(const Vector &a, const Vector &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

const FacetRule &rule_of(const Facet &facet) {
  return facet_rule(facet.shape->dimension, facet.shape->nodes);
}

std::vector<FacetPoint> points_of_facet(const Mesh &mesh, const Facet &facet) {
  const FacetRule &rule = rule_of(facet);
  std::vector<FacetPoint> points(static_cast<std::size_t>(rule.points));
  for (int q = 0; q < rule.points; ++q) {
    FacetPoint &point = points[static_cast<std::size_t>(q)];
    Vector tangents[2] = {};
    if (rule.dimension == 1) tangents[1] = {0, 0, 1};  // leads out of the plane of an edge
    point.values = rule.values[q];
    for (int a = 0; a < rule.nodes; ++a) {
      const double *p = &mesh.coordinates[static_cast<std::size_t>(3 * facet.begin()[a])];
      for (std::size_t i = 0; i < 3; ++i) {
        point.position[i] += rule.values[q][a] * p[i];
        for (int k = 0; k < rule.dimension; ++k) tangents[k][i] += rule.gradients[q][a][k] * p[i];
      }
    }
    const Vector normal = cross(tangents[0], tangents[1]);
    const double size = std::hypot(normal[0], normal[1], normal[2]);
    for (std::size_t i = 0; i < 3; ++i) point.normal[i] = normal[i] / size;
    point.area = size * rule.weights[q];
  }
  return points;
}

PetscErrorCode area_of_facets(const Mesh &mesh, const std::vector<Facet> &facets, double *area) {
  PetscFunctionBeginUser;
  *area = 0;
  for (const Facet &facet : facets) {
    for (const FacetPoint &point : points_of_facet(mesh, facet)) *area += point.area;
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, area, 1, MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
