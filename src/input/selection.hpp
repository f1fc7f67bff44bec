#pragma once

#include <string>
#include <vector>

#include "input/expression.hpp"
#include "mesh/boundary.hpp"

namespace trefoil {

/// What the user chooses of a mesh: what a formula takes, or a group of the mesh file; what both
/// take where there are both.
struct Choice {
  std::string where, group;
  std::string option;    ///< whose it is, for messages: "-constraint_wall"
  double tolerance = 0;  ///< length within which ==, <= and >= hold

  /// "-constraint_wall_where is 'x == xmin'"
  [[nodiscard]] std::string text() const;
};

/// Local vertices that are taken, ghosts included, 1 a vertex.
struct ChosenVertices {
  std::vector<char> taken;
  std::vector<char> nearly;  ///< not taken, but would be if moved by the tolerance
};

/// Facets of the body's surface that are taken, each on one rank.
struct ChosenFacets {
  std::vector<Facet> facets;
  PetscInt64 count = 0;   ///< of all ranks
  PetscInt64 nearly = 0;  ///< of all ranks: those that the tolerance would add
  double area = 0;        ///< at rest, of all ranks; in the plane a length
};

Box box_of(const Mesh &mesh);

/// "-constraint_wall_where would take 6 more vertices ...": where the tolerance decides.
std::string warn_of_rest(const Choice &choice, PetscInt64 count, const std::string &things);

/// Whether the formula depends on t. Collective; what is wrong with it is an error with one
/// sentence on all ranks.
PetscErrorCode depends_on_time(const Mesh &mesh, const Choice &choice, bool *depends);

/// Chooses vertices at their rest positions; of a group of any dimension, all nodes. Collective;
/// what is wrong with the choice is an error with one sentence on all ranks.
PetscErrorCode choose_vertices(const Mesh &mesh, const Choice &choice, double time,
                               ChosenVertices *chosen);

/// Chooses facets: those of a group of surfaces, in the plane of curves, or all whose corners the
/// formula takes. Collective. Errors: as above, and a group with facets inside of the body.
PetscErrorCode choose_facets(const Mesh &mesh, const Choice &choice, double time,
                             ChosenFacets *facets);

/// The area of the facets that chosen vertices span. Collective.
PetscErrorCode area_between(const Mesh &mesh, const ChosenVertices &chosen, double *area);

/// How many vertices of all ranks are marked. Collective.
PetscErrorCode count_vertices(const Mesh &mesh, const std::vector<char> &marked, PetscInt64 *count);

}  // namespace trefoil
