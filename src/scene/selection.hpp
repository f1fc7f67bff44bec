#pragma once

#include <string>
#include <vector>

#include "mesh/boundary.hpp"
#include "scene/expression.hpp"

namespace trefoil {

/// What a `where` of the user takes of a mesh.
struct Choice {
  std::string where;
  std::string option;    ///< whose it is, for messages: "-constraint_wall_where"
  double tolerance = 0;  ///< length within which ==, <= and >= hold
};

/// Local vertices that are taken, ghosts included, 1 a vertex.
struct ChosenVertices {
  std::vector<char> taken;
  std::vector<char> nearly;  ///< not taken, but would be if moved by the tolerance
};

/// Facets of the body's surface all of whose corners are taken, each on one rank.
struct ChosenFacets {
  std::vector<Facet> facets;
  PetscInt64 count = 0;   ///< of all ranks
  PetscInt64 nearly = 0;  ///< of all ranks: those that the tolerance would add
  double area = 0;        ///< at rest, of all ranks; in the plane a length
};

Box box_of(const Mesh &mesh);

/// "-constraint_wall_where would take 6 more vertices ...": where the tolerance decides.
std::string warn_of_rest(const Choice &choice, PetscInt64 count, const std::string &things);

/// Chooses vertices at their rest positions. Collective; what is wrong with the formula is an error
/// with one sentence on all ranks.
PetscErrorCode choose_vertices(const Mesh &mesh, const Choice &choice, double time,
                               ChosenVertices *chosen);

/// The facets between chosen vertices. Collective.
PetscErrorCode choose_facets(const Mesh &mesh, const ChosenVertices &chosen, ChosenFacets *facets);

/// How many vertices of all ranks are marked. Collective.
PetscErrorCode count_vertices(const Mesh &mesh, const std::vector<char> &marked, PetscInt64 *count);

}  // namespace trefoil
