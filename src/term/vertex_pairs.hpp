#pragma once

#include <petscsys.h>

#include <vector>

namespace trefoil {

/// Pairs of vertices, by their numbers in the whole mesh, whose unknowns a term couples.
struct VertexPairs {
  std::vector<PetscInt> first, second;
};

}  // namespace trefoil
