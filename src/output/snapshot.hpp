#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

namespace trefoil {

/// One rank's part of a mesh and of the fields on it. Vertices are owned by exactly one rank and
/// numbered globally rank by rank: rank 0's first, in the order of `points`.
struct Snapshot {
  /// A field on the vertices or on the cells.
  struct Field {
    std::string name;            ///< as ParaView shows it, for example "displacement"; no slash
    bool on_vertices = true;     ///< false: one value a cell
    int components = 1;          ///< 1 or 3
    std::vector<double> values;  ///< owned vertices (or local cells) x components
  };
  int dim = 3;
  int corners = 4;              ///< nodes of a cell: 4 or 10 of a tetrahedron, 3 or 6 of a triangle
  std::vector<double> points;   ///< owned vertices x dim, rest positions
  std::vector<PetscInt> cells;  ///< local cells x corners, global vertex numbers
  std::vector<Field> fields;
};

/// Writes `path` (XDMF 3) and, beside it, an HDF5 file of the same name (.h5) with the data, in
/// parallel. Collective. Nothing appears under a final name before it is whole: both are written
/// beside (.part) and renamed, the XDMF last. On failure no part is left.
/// @param comm the ranks that hold the mesh; any of them may hold nothing of it
/// @param path name of the XDMF file, ending in .xdmf
/// @param snapshot this rank's part; the same fields in the same order on all ranks
/// @return PETSC_ERR_FILE_OPEN with one sentence, on all ranks, where a file cannot be written, the
/// disk is too small included; PETSC_ERR_ARG_SIZ where the arrays do not fit together
PetscErrorCode write_snapshot(MPI_Comm comm, const std::string &path, const Snapshot &snapshot);

/// Asks whether `path` can be written, without leaving anything behind; for use before a long
/// solve. Collective; PETSC_ERR_FILE_OPEN on all ranks, with one sentence, where it cannot.
PetscErrorCode check_writable(MPI_Comm comm, const std::string &path);

}  // namespace trefoil
