#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "contact/vector3.hpp"

namespace trefoil::contact {

/// What moves a vertex. Of several vertices the first one in this order decides what they are.
enum class Role : std::uint8_t {
  free,        ///< an unknown
  prescribed,  ///< a held or moved vertex of a body
  obstacle     ///< belongs to no body of the scene: it has no unknown and no owner
};

/// A vertex of the surface, as the mesh or an obstacle gives it.
struct SurfaceVertex {
  Vector3 rest;              ///< rest position
  std::int64_t number = -1;  ///< in the user's file, for messages
  int body = 0;              ///< connected bodies and obstacles, numbered over all of them
  int owner = 0;             ///< the rank that owns it; -1: an obstacle
  Role role = Role::free;
};

/// A triangle of the surface; in the plane an edge, with vertices[2] = -1.
struct SurfaceFacet {
  std::array<int, 3> vertices{-1, -1, -1};
  double stiffness = 0;  ///< kappa of the body behind it, Pa; infinity for an obstacle
};

/// A vertex, edge or facet, as far as it concerns which pairs there are.
struct Primitive {
  int body = 0;
  int owner = 0;
  Role role = Role::free;
  double area = 0;       ///< rest area that stands for it; in the plane a length
  double stiffness = 0;  ///< the least kappa of the facets around it, Pa
};

/// The whole surface of all bodies and obstacles, the same on every rank.
///
/// Vertices ascend by global number: index order is number order, on any number of ranks, so that
/// sums over pairs sorted by index differ between numbers of ranks by rounding only.
struct Surface {
  int dim = 3;
  std::vector<SurfaceVertex> vertices;
  std::vector<std::array<int, 3>> facets;  ///< corners ascending; sorted
  std::vector<std::array<int, 2>> edges;   ///< likewise; in the plane the facets themselves
  std::vector<Primitive> vertex_data, edge_data, facet_data;

  [[nodiscard]] int vertex_count() const { return static_cast<int>(vertices.size()); }
  [[nodiscard]] int edge_count() const { return static_cast<int>(edges.size()); }
  [[nodiscard]] int facet_count() const { return static_cast<int>(facets.size()); }
  /// Rest positions, 3 a vertex.
  [[nodiscard]] std::vector<double> rest_positions() const;
};

/// Sorts facets, finds edges, and shares out rest areas: a vertex or edge gets a third of each
/// triangle around it, a vertex of a plane body half of each edge.
/// @param dim       2 or 3
/// @param vertices  ascending by global number; those in no facet stay without area
/// @param facets    each once, in any order, vertices as indices into `vertices`
Surface make_surface(int dim, std::vector<SurfaceVertex> vertices,
                     std::vector<SurfaceFacet> facets);

/// The diagonal of the box of all bodies at rest, obstacles left out: the length that dhat is a
/// share of; 0 without bodies.
double body_diagonal(const Surface &surface);

/// What two primitives are together: the first of their roles.
inline Role joint_role(const Primitive &a, const Primitive &b) {
  return a.role < b.role ? a.role : b.role;
}

/// The rank that computes a pair: the owner of the first of its vertices that has one.
inline int owner_of_pair(const Primitive &a, const Primitive &b) {
  return a.owner >= 0 ? a.owner : b.owner;
}

}  // namespace trefoil::contact
