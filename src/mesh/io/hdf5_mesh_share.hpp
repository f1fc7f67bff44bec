#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mesh/cell_shape.hpp"
#include "mesh/distribution.hpp"

namespace trefoil {

/// A list that ranks have read in shares: the check of this rank's part, and what it should be in
/// all.
struct ReadList {
  std::string name;
  std::uint64_t check;
  PetscInt kept;
};

/// What one rank reads: even shares, and the tables of groups.
struct FileShare {
  PetscInt format = 0;
  std::vector<ReadList> lists;
  const CellShape *shape = nullptr;
  PetscInt total_cells = 0, total_vertices = 0;
  Share mesh;
  GroupTables tables;
  std::size_t sets = 0;  ///< of groups, in the tables
  /// Of each dimension below the cells': rows of cell, set, corners.
  std::array<std::vector<PetscInt>, 3> entities;
};

/// Corners of an entity below the cells; 0: the mesh has none of this dimension.
int corners_below(const CellShape &shape, std::size_t dimension);

/// Reads this rank's share. Throws InputError.
FileShare read_share(const std::string &path, PetscInt rank, PetscInt ranks);

}  // namespace trefoil
