#pragma once

#include <array>
#include <vector>

#include "element/facet_rule.hpp"
#include "mesh/boundary.hpp"

namespace trefoil {

/// A point of quadrature on a facet at rest.
struct FacetPoint {
  std::array<double, 3> position{};
  std::array<double, 3> normal{};  ///< of length one, out of the body
  double area = 0;                 ///< that it stands for; of an edge, its length
  const double *values = nullptr;  ///< of the shape functions of the facet's nodes
};

/// The rule of a facet's shape.
const FacetRule &rule_of(const Facet &facet);

/// The points of quadrature of a facet, straight or bent.
std::vector<FacetPoint> points_of_facet(const Mesh &mesh, const Facet &facet);

/// The sum of the facets' areas, in the plane of their lengths. Collective.
PetscErrorCode area_of_facets(const Mesh &mesh, const std::vector<Facet> &facets, double *area);

}  // namespace trefoil
