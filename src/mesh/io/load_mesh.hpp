#pragma once

#include <functional>
#include <string>

#include "mesh/mesh.hpp"

namespace trefoil {

/// Where a mesh comes from and what is done to it.
struct MeshOptions {
  std::string file, generate;    ///< one of them
  PetscInt resolution = 0;       ///< of a generated mesh
  PetscInt refine = 0;           ///< how often all edges are halved
  PetscInt order = 0;            ///< of the elements: 1, 2; 0: as the mesh has it
  bool normalize = false;        ///< centred, farthest vertex at distance 1
  bool drops_bad_cells = false;  ///< -mesh_repair drop
  std::string partitioner = "metis";

  [[nodiscard]] std::string name() const { return file.empty() ? "generated " + generate : file; }
};

/// Reads or generates a mesh on the first rank (one in HDF5 on all, in even shares), checks it,
/// distributes it; says on the first rank's screen what was done to it and, in the line `mesh:
/// ...`, what it is. Collective; what makes no mesh is an error with one sentence on all ranks.
/// @param check called on the first rank with the cells as the file has them; throws InputError
/// where the elements cannot be made of these
PetscErrorCode load_mesh(MPI_Comm comm, const MeshOptions &options,
                         const std::function<void(const CellList &)> &check, Mesh *mesh);

}  // namespace trefoil
