#pragma once

#include <span>
#include <vector>

#include "contact/candidates.hpp"
#include "contact/predicates.hpp"

namespace trefoil::contact {

/// An edge and a facet (in the plane another edge) without a common vertex that meet.
struct Intersection {
  int edge = 0, facet = 0;
  Meeting meeting = Meeting::crossing;
  Vector3 place;  ///< in both of them, to rounding

  bool operator<(const Intersection &other) const {
    return edge != other.edge ? edge < other.edge : facet < other.facet;
  }
};

/// All intersections of the surface at x, by exact predicates, sorted. Two surfaces of triangles
/// meet where an edge of one meets a triangle of the other. Of what `search` leaves out - bodies
/// with themselves, obstacles among each other, other ranks' - nothing is said; its reach is not
/// used. A rank owns what the first of its vertices with an owner belongs to, the edge's first.
std::vector<Intersection> find_intersections(const Surface &surface, std::span<const double> x,
                                             const PairSearch &search);

}  // namespace trefoil::contact
