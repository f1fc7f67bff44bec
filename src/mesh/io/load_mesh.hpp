#pragma once

#include <functional>
#include <string>
#include <vector>

#include "mesh/bodies.hpp"
#include "mesh/mesh.hpp"

namespace trefoil {

/// Where a mesh comes from and what is done to it.
struct MeshOptions {
  std::string file, generate;        ///< one of them, or
  std::vector<BodySource> bodies{};  ///< several, each from where it says
  PetscInt resolution = 0;           ///< of a generated mesh
  PetscInt refine = 0;               ///< how often all edges are halved
  PetscInt order = 0;                ///< of the elements: 1, 2; 0: as the mesh has it
  bool normalize = false;            ///< centred, farthest vertex at distance 1
  bool drops_bad_cells = false;      ///< -mesh_repair drop
  std::string partitioner = "metis";

  [[nodiscard]] std::string name() const;
};

/// Reads or generates a mesh on the first rank (one in HDF5 on all, in even shares), checks it,
/// distributes it; says on the first rank's screen what was done to it and, in the line `mesh:
/// ...`, what it is. Collective; what makes no mesh is an error with one sentence on all ranks.
/// @param check called on the first rank with the cells as a file has them, and its name; throws
/// InputError where the elements cannot be made of these
PetscErrorCode load_mesh(
    MPI_Comm comm, const MeshOptions &options,
    const std::function<void(const CellList &, const std::string &name)> &check, Mesh *mesh);

}  // namespace trefoil
