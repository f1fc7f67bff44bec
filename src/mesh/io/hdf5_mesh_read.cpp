#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "mesh/distribution.hpp"
#include "mesh/io/hdf5_mesh.hpp"
#include "mesh/io/hdf5_mesh_names.hpp"
#include "mesh/io/hdf5_reader.hpp"
#include "mesh/parallel_partition.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// What one rank reads: even shares, and the tables of groups.
struct FileShare {
  const CellShape *shape = nullptr;
  PetscInt total_cells = 0, total_vertices = 0;
  Share mesh;
  GroupTables tables;
  std::size_t sets = 0;  ///< of groups, in the tables
  /// Of each dimension below the cells': rows of cell, set, corners.
  std::array<std::vector<PetscInt>, 3> entities;
};

/// Corners of an entity below the cells; 0: the mesh has none of this dimension.
int corners_below(const CellShape &shape, std::size_t dimension) {
  for (const CellShape *facet = shape.facet; facet; facet = facet->facet) {
    if (static_cast<std::size_t>(facet->dimension) == dimension) return facet->corners;
  }
  return 0;
}

/// Begin and number of a rank's even share.
std::array<PetscInt, 2> share_of(PetscInt total, PetscInt rank, PetscInt ranks) {
  const PetscInt least = total / ranks, larger = total % ranks;
  return {rank * least + std::min(rank, larger), least + (rank < larger)};
}

/// Reads a list of one number for each of `total`, in even shares.
class ShareReader {
 public:
  ShareReader(const Hdf5Reader &file, PetscInt rank, PetscInt ranks)
      : file_(file), rank_(rank), ranks_(ranks) {}

  std::vector<PetscInt> integers(const std::string &name, PetscInt total, PetscInt width,
                                 PetscInt least, PetscInt most) const {
    const auto [first, count] = share_of(total, rank_, ranks_);
    check_size(name, total, width);
    std::vector<PetscInt> numbers = file_.integers(name, first * width, count * width);
    for (const PetscInt number : numbers)
      if (number < least || number > most)
        file_.fail("has " + std::to_string(number) + " in " + name + ", where no such can be");
    return numbers;
  }

  std::vector<double> reals(const std::string &name, PetscInt total, PetscInt width) const {
    const auto [first, count] = share_of(total, rank_, ranks_);
    check_size(name, total, width);
    std::vector<double> numbers = file_.reals(name, first * width, count * width);
    for (const double number : numbers)
      if (!std::isfinite(number)) file_.fail("has a number that is not finite in " + name);
    return numbers;
  }

 private:
  void check_size(const std::string &name, PetscInt total, PetscInt width) const {
    if (file_.size(name) != total * width)
      file_.fail("has another number of entries in " + name + " than its header says");
  }

  const Hdf5Reader &file_;
  PetscInt rank_, ranks_;
};

void read_header(const Hdf5Reader &file, FileShare *share) {
  using namespace hdf5_names;
  if (!file.has(header)) file.fail("is HDF5, but no mesh that Trefoil has written");
  if (file.size(header) != header_size) file.fail("is damaged in its header");
  const std::vector<PetscInt> numbers = file.integers(header, 0, header_size);
  if (numbers[0] != format)
    file.fail("is a mesh in format " + std::to_string(numbers[0]) + ", which is not known here");
  const auto shapes = mesh_shapes();
  const bool is_known = numbers[1] >= 0 && numbers[1] < static_cast<PetscInt>(shapes.size());
  if (!is_known || numbers[2] < 1 || numbers[3] < 1 || numbers[4] < 0)
    file.fail("is damaged in its header");
  share->shape = shapes[static_cast<std::size_t>(numbers[1])];
  share->total_cells = numbers[2];
  share->total_vertices = numbers[3];
  share->mesh.file_vertices = numbers[4];
  const PetscInt most = PETSC_MAX_INT / share->shape->nodes;
  if (share->total_cells > most || share->total_vertices > PETSC_MAX_INT / 3)
    file.fail("has more cells than this PETSc can number, or is damaged");
}

void read_groups(const Hdf5Reader &file, const ShareReader &shares, FileShare *share) {
  using namespace hdf5_names;
  if (!file.has(groups)) return;
  Groups known;
  share->tables.numbers = file.integers(groups, 0, file.size(groups));
  if (file.has(group_names)) {
    for (const PetscInt letter : file.integers(group_names, 0, file.size(group_names)))
      share->tables.names += static_cast<char>(letter);
  }
  try {
    unpack_groups(share->tables, &known);
  } catch (const InputError &) {
    file.fail("has damaged tables of groups");
  }
  share->sets = known.sets().size();
  const auto last_set = static_cast<PetscInt>(share->sets) - 1;
  if (file.has(cell_set)) {
    share->mesh.sets = shares.integers(cell_set, share->total_cells, 1, 0, last_set);
  }
  for (std::size_t dimension = 0; dimension < share->entities.size(); ++dimension) {
    const PetscInt width = 2 + corners_below(*share->shape, dimension);
    if (width == 2 || !file.has(entities(dimension))) continue;
    const PetscInt rows = file.size(entities(dimension)) / width;
    auto &mine = share->entities[dimension];
    mine = shares.integers(entities(dimension), rows, width, 0, PETSC_MAX_INT);
    for (std::size_t k = 0; k < mine.size(); k += static_cast<std::size_t>(width))
      if (mine[k] >= share->total_cells || mine[k + 1] > last_set)
        file.fail("is damaged in " + entities(dimension));
  }
}

/// Reads this rank's share. Throws InputError.
FileShare read_share(const std::string &path, PetscInt rank, PetscInt ranks) {
  using namespace hdf5_names;
  const Hdf5Reader file(path);
  const ShareReader shares(file, rank, ranks);
  FileShare share;
  read_header(file, &share);
  // PETSc numbers the cells first: vertices come behind them.
  const PetscInt first_vertex = share.total_cells;
  if (first_vertex > PETSC_MAX_INT - share.total_vertices)
    file.fail("has more cells and vertices than this PETSc can number");
  share.mesh.cells = shares.integers(cells, share.total_cells, share.shape->nodes, first_vertex,
                                     first_vertex + share.total_vertices - 1);
  for (PetscInt &vertex : share.mesh.cells) vertex -= first_vertex;
  const auto width = static_cast<std::size_t>(share.shape->nodes);
  for (std::size_t c = 0; c < share.mesh.cells.size(); c += width) {
    std::vector<PetscInt> nodes(share.mesh.cells.begin() + static_cast<std::ptrdiff_t>(c),
                                share.mesh.cells.begin() + static_cast<std::ptrdiff_t>(c + width));
    std::sort(nodes.begin(), nodes.end());
    if (std::adjacent_find(nodes.begin(), nodes.end()) != nodes.end())
      file.fail("has a cell with the same vertex twice");
  }
  share.mesh.coordinates = shares.reals(points, share.total_vertices, 3);
  share.mesh.is_numbered = true;
  share.mesh.cell_number = shares.integers(cell_number, share.total_cells, 1, 0, PETSC_MAX_INT - 1);
  share.mesh.vertex_number =
      shares.integers(vertex_number, share.total_vertices, 1, 0, PETSC_MAX_INT - 1);
  read_groups(file, shares, &share);
  return share;
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
