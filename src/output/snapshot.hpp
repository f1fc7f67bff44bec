#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

#include "mesh/cell_shape.hpp"

namespace trefoil {

/// One rank's part of a mesh that is written. Vertices and cells stand in the file in the order of
/// their numbers, whichever ranks have them; numbers start from 0, need not follow each other, and
/// each is given once.
struct OutputMesh {
  const CellShape *shape = &shapes::tet4;
  std::vector<double> points;           ///< owned vertices x 3, rest positions
  std::vector<PetscInt> point_numbers;  ///< of each owned vertex
  std::vector<PetscInt> cells;          ///< local cells x nodes of the shape, numbers of vertices
  std::vector<PetscInt> cell_numbers;   ///< of each local cell
  /// Names of obstacles, the same on all ranks, where each has an output of its own beside this.
  std::vector<std::string> obstacles{};
};

/// One rank's part of a field on the vertices or on the cells.
struct Field {
  std::string name;         ///< as ParaView shows it, for example "displacement"; no slash
  bool on_vertices = true;  ///< false: one value a cell
  /// 1: a scalar, 3: a vector, 6: a symmetric tensor xx xy xz yy yz zz, 9: a tensor, row by row;
  /// other numbers are written as they are.
  int components = 1;
  std::vector<double> values;  ///< owned vertices (or local cells) x components
};

/// Writes one state of a mesh, in parallel. Collective. Nothing appears under a final name before
/// it is whole: files are written beside (.part) and renamed. On failure no part is left.
/// @param comm the ranks that hold the mesh; any of them may hold nothing of it
/// @param path its ending decides: .xdmf, XDMF 3 with the data in an HDF5 file of the same name
/// (.h5) beside it; .vtu, VTK's unstructured grid
/// @param fields the same in the same order on all ranks
/// @return PETSC_ERR_FILE_OPEN with one sentence, on all ranks, where a file cannot be written, the
/// disk is too small included; PETSC_ERR_ARG_SIZ where the arrays do not fit together
PetscErrorCode write_snapshot(MPI_Comm comm, const std::string &path, const OutputMesh &mesh,
                              const std::vector<Field> &fields);

/// Asks whether an output can be written to `path`, without leaving anything behind; for use before
/// a long solve. Collective; PETSC_ERR_FILE_OPEN on all ranks, with one sentence, where it cannot.
PetscErrorCode check_writable(MPI_Comm comm, const std::string &path);

/// The files that an output to `path` consists of, `path` first.
std::vector<std::string> files_of_output(const std::string &path);

}  // namespace trefoil
