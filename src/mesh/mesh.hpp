#pragma once

#include <petscdmplex.h>

#include <array>
#include <string>
#include <vector>

#include "mesh/cell_list.hpp"

namespace trefoil {

/// One rank's part of a distributed mesh: a DMPlex (cells and vertices, not interpolated), and flat
/// arrays taken from it once, for the element loops.
///
/// Vertices are all nodes of the elements, midpoints of edges included (see CellList): to the
/// DMPlex a quadratic tetrahedron is a cell of ten vertices, so that no edges and faces need be
/// made. Points have three coordinates and vertices three displacements, of which a plane body, in
/// z = 0, leaves the third at rest (plane strain).
struct Mesh {
  Mesh() = default;
  Mesh(const Mesh &) = delete;
  Mesh &operator=(const Mesh &) = delete;
  ~Mesh();

  DM dm = nullptr;
  PetscInt first_vertex = 0;               ///< DMPlex point of local vertex 0
  const CellShape *shape = &shapes::tet4;  ///< of all cells
  std::vector<PetscInt> cells;             ///< local cells x nodes_per_cell(), local vertex numbers
  std::vector<double> coordinates;         ///< local vertices (ghosts included) x 3, rest positions
  std::vector<PetscInt> global_vertex;     ///< of each local vertex; ranks own consecutive ranges
  std::vector<char> owned;                 ///< of each local vertex: this rank owns it
  Groups groups;  ///< of local cells and vertices, counts of the whole mesh
  /// Of each local vertex and cell, where it came in the mesh file (see CellList).
  std::vector<PetscInt> vertex_number, cell_number;
  PetscInt file_vertices = 0;       ///< vertices of the file: others have higher numbers
  std::vector<BodyNumbers> bodies;  ///< of several files, the same on all ranks
  std::vector<PetscInt> part;       ///< of each local vertex: the unconnected part it is in
  std::array<double, 3> box_min{}, box_max{};  ///< of the whole mesh

  PetscInt total_cells = 0, total_vertices = 0;
  PetscInt total_corners = 0;  ///< vertices that are no midpoints of edges
  PetscInt parts = 1;          ///< that hang together by no vertex
  PetscInt edge_cut = 0;       ///< faces between cells of different ranks
  double imbalance = 1;        ///< largest part over the mean part, in cells

  [[nodiscard]] int dimension() const { return shape->dimension; }
  [[nodiscard]] int nodes_per_cell() const { return shape->nodes; }
  [[nodiscard]] PetscInt local_cells() const {
    return static_cast<PetscInt>(cells.size()) / nodes_per_cell();
  }
  /// "tri3", "tri6", "tet4" or "tet10".
  [[nodiscard]] std::string element_name() const { return shape->name; }
  [[nodiscard]] PetscInt local_vertices() const {
    return static_cast<PetscInt>(coordinates.size()) / 3;
  }
  /// Bytes of the flat arrays on this rank.
  [[nodiscard]] double bytes() const;
};

/// The mean of a local cell's corners.
std::array<double, 3> centroid_of_cell(const Mesh &mesh, std::size_t cell);

/// A rank for each cell, chosen on the rank that holds the whole mesh.
struct Partition {
  std::vector<PetscInt> rank_of_cell;
  PetscInt edge_cut = 0;
};

/// Divides the cells' dual graph (cells that share a face) into `parts`; no part is empty.
/// @param partitioner "metis", or the name of one of PETSc's partitioners, for example "ptscotch"
/// @param whole the mesh, on the first rank; ignored on the others
/// @param shape of its cells, known on all ranks
/// Collective. An unknown partitioner or more parts than cells is an error on all ranks.
PetscErrorCode partition_cells(MPI_Comm comm, const CellList &whole, const CellShape &shape,
                               const std::string &partitioner, Partition *partition);

/// Sends each rank its cells and builds the distributed DMPlex from them: partitioned before it is
/// made, and never interpolated, which is 10 to 40 times cheaper than the other way round.
/// Then refines linear cells uniformly `refine` times (8 tetrahedra or 4 triangles from one).
/// Groups and the file's numbers go along.
/// Collective; `whole` matters on the first rank only.
PetscErrorCode distribute_mesh(MPI_Comm comm, const CellList &whole, const std::string &partitioner,
                               PetscInt refine, Mesh *mesh);

/// Numbers the connected components of the mesh from 0: one number for each local vertex.
/// Collective.
PetscErrorCode connected_components(const Mesh &mesh, std::vector<PetscInt> *component,
                                    PetscInt *count);

}  // namespace trefoil
