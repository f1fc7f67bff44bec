#include <array>
#include <fstream>

#include "mesh/distribution.hpp"
#include "mesh/io/hdf5_mesh.hpp"
#include "mesh/io/hdf5_mesh_share.hpp"
#include "mesh/io/list_check.hpp"
#include "mesh/parallel_partition.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Whether all that ranks have read in shares is what was written. Collective.
PetscErrorCode check_lists(MPI_Comm comm, const std::string &path,
                           const std::vector<ReadList> &lists) {
  std::vector<std::uint64_t> checks;
  PetscFunctionBeginUser;
  for (const ReadList &list : lists) checks.push_back(list.check);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, checks.data(), static_cast<PetscMPIInt>(checks.size()),
                             MPI_UINT64_T, MPI_SUM, comm));
  for (std::size_t k = 0; k < lists.size(); ++k) {
    PetscCheck(kept_check(checks[k]) == lists[k].kept, comm, PETSC_ERR_USER_INPUT,
               "%s is damaged in %s: it is not what was written; write it again by -mesh_write",
               path.c_str(), lists[k].name.c_str());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends every cell, with its number and its set, to its rank. Collective.
PetscErrorCode send_cells(MPI_Comm comm, const Partition &partition, const CellShape &shape,
                          Share *share) {
  const auto nodes = static_cast<std::size_t>(shape.nodes);
  int has_sets = !share->sets.empty();
  std::vector<PetscInt> rows, received;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &has_sets, 1, MPI_INT, MPI_MAX, comm));
  const std::size_t cells = share->cell_number.size();
  for (std::size_t c = 0; c < cells; ++c) {
    const auto first = share->cells.begin() + static_cast<std::ptrdiff_t>(nodes * c);
    rows.insert(rows.end(), first, first + static_cast<std::ptrdiff_t>(nodes));
    rows.push_back(share->cell_number[c]);
    rows.push_back(has_sets ? share->sets[c] : 0);
  }
  PetscCall(send_rows(comm, rows, shape.nodes + 2, partition.rank_of_cell, &received));
  share->cells.clear();
  share->cell_number.clear();
  share->sets.clear();
  for (auto row = received.begin(); row != received.end(); row += shape.nodes + 2) {
    share->cells.insert(share->cells.end(), row, row + shape.nodes);
    share->cell_number.push_back(row[shape.nodes]);
    if (has_sets) share->sets.push_back(row[shape.nodes + 1]);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Sends what is in groups to the ranks of their cells, and takes it in. Collective.
PetscErrorCode send_entities(MPI_Comm comm, const std::string &path, const FileShare &share,
                             const Partition &partition, const std::vector<PetscInt> &whole_number,
                             Mesh *mesh) {
  std::vector<PetscInt> mine;  // as take_entities() wants it
  PetscFunctionBeginUser;
  for (std::size_t dimension = 0; dimension < share.entities.size(); ++dimension) {
    const int width = 2 + corners_below(*share.shape, dimension);
    std::vector<PetscInt> cells, ranks, received;
    const auto &rows = share.entities[dimension];
    for (std::size_t k = 0; k < rows.size(); k += static_cast<std::size_t>(width)) {
      cells.push_back(rows[k]);
    }
    PetscCall(fetch_from_shares(comm, partition.rank_of_cell, cells, &ranks));
    PetscCall(send_rows(comm, rows, width, ranks, &received));
    mine.push_back(static_cast<PetscInt>(received.size()) / width);
    for (auto row = received.begin(); row != received.end(); row += width) mine.push_back(row[1]);
    for (auto row = received.begin(); row != received.end(); row += width) {
      mine.insert(mine.end(), row + 2, row + width);
    }
  }
  const std::string complaint =
      complaint_of([&] { take_entities(mine, whole_number, *share.shape, &mesh->groups); });
  PetscCall(agree_on_complaint(comm, complaint.empty() ? "" : path + " is damaged: " + complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

bool is_hdf5_file(const std::string &path) {
  std::array<char, 8> beginning{};
  std::ifstream file(path, std::ios::binary);
  file.read(beginning.data(), beginning.size());
  return file && std::string(beginning.data(), beginning.size()) == "\x89HDF\r\n\x1a\n";
}

PetscErrorCode read_hdf5_mesh(MPI_Comm comm, const std::string &path,
                              const std::string &partitioner, PetscInt refine, Mesh *mesh) {
  PetscMPIInt rank = 0, ranks = 0;
  FileShare share;
  Partition partition;
  std::vector<PetscInt> whole_number;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  const std::string complaint = complaint_of([&] { share = read_share(path, rank, ranks); });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscCall(check_lists(comm, path, share.lists));
  mesh->shape = share.shape;
  PetscCheck(!is_quadratic(*mesh->shape) || refine == 0, comm, PETSC_ERR_USER_INPUT,
             "-mesh_refine works on linear cells, and those of %s are quadratic; refine when it is "
             "written by -mesh_write",
             path.c_str());
  PetscCall(partition_shares(comm, share.mesh.cells, *share.shape, share.total_vertices,
                             partitioner == "metis" ? "ptscotch" : partitioner, &partition));
  mesh->edge_cut = partition.edge_cut;
  PetscCall(send_cells(comm, partition, *share.shape, &share.mesh));
  PetscCall(make_from_shares(comm, share.mesh, mesh, &whole_number));
  unpack_groups(share.tables.numbers.empty() ? pack_groups({}) : share.tables, &mesh->groups);
  PetscCall(send_entities(comm, path, share, partition, whole_number, mesh));
  PetscCall(complete_mesh(comm, refine, mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
