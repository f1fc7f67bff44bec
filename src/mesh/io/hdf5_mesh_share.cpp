#include "mesh/io/hdf5_mesh_share.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "mesh/io/hdf5_mesh_names.hpp"
#include "mesh/io/hdf5_reader.hpp"
#include "mesh/io/list_check.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// Begin and number of a rank's even share.
std::array<PetscInt, 2> share_of(PetscInt total, PetscInt rank, PetscInt ranks) {
  const PetscInt least = total / ranks, larger = total % ranks;
  return {rank * least + std::min(rank, larger), least + (rank < larger)};
}

[[noreturn]] void fail_in(const Hdf5Reader &file, const std::string &name) {
  file.fail("is damaged in " + name + ": it is not what was written");
}

/// What the file keeps of a list's check. Throws InputError.
PetscInt kept_of(const Hdf5Reader &file, const std::string &name) {
  const PetscInt kept = file.attribute(name, hdf5_names::check);
  if (kept < 0) fail_in(file, name);
  return kept;
}

/// A list that every rank reads, of a file of some format.
std::vector<PetscInt> whole_list(const Hdf5Reader &file, const std::string &name,
                                 PetscInt format = hdf5_names::format) {
  std::vector<PetscInt> numbers = file.integers(name, 0, file.size(name));
  const std::uint64_t check = check_of_entries(0, std::span<const PetscInt>(numbers));
  if (format > 1 && kept_of(file, name) != kept_check(check)) fail_in(file, name);
  return numbers;
}

/// Reads a list of one number for each of `total`, in even shares.
class ShareReader {
 public:
  ShareReader(const Hdf5Reader &file, PetscInt rank, PetscInt ranks, FileShare *share)
      : file_(file), rank_(rank), ranks_(ranks), share_(share) {}

  std::vector<PetscInt> integers(const std::string &name, PetscInt total, PetscInt width,
                                 PetscInt least, PetscInt most) const {
    const auto [first, count] = share_of(total, rank_, ranks_);
    check_size(name, total, width);
    std::vector<PetscInt> numbers = file_.integers(name, first * width, count * width);
    add_check(name, first * width, numbers);
    for (const PetscInt number : numbers)
      if (number < least || number > most)
        file_.fail("has " + std::to_string(number) + " in " + name + ", where no such can be");
    return numbers;
  }

  std::vector<double> reals(const std::string &name, PetscInt total, PetscInt width) const {
    const auto [first, count] = share_of(total, rank_, ranks_);
    check_size(name, total, width);
    std::vector<double> numbers = file_.reals(name, first * width, count * width);
    add_check(name, first * width, numbers);
    for (const double number : numbers)
      if (!std::isfinite(number)) file_.fail("has a number that is not finite in " + name);
    return numbers;
  }

 private:
  template <class Number>
  void add_check(const std::string &name, PetscInt64 first, const std::vector<Number> &part) const {
    if (share_->format == 1) return;
    share_->lists.push_back(
        {name, check_of_entries(first, std::span<const Number>(part)), kept_of(file_, name)});
  }
  void check_size(const std::string &name, PetscInt total, PetscInt width) const {
    if (file_.size(name) != total * width)
      file_.fail("has another number of entries in " + name + " than its header says");
  }

  const Hdf5Reader &file_;
  PetscInt rank_, ranks_;
  FileShare *share_;
};

void read_header(const Hdf5Reader &file, FileShare *share) {
  using namespace hdf5_names;
  if (!file.has(header)) file.fail("is HDF5, but no mesh that Trefoil has written");
  if (file.size(header) != header_size) file.fail("is damaged in its header");
  share->format = file.integers(header, 0, 1)[0];
  if (share->format < 1 || share->format > format)
    file.fail("is a mesh in format " + std::to_string(share->format) + ", which is not known here");
  const std::vector<PetscInt> numbers = whole_list(file, header, share->format);
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
  share->tables.numbers = whole_list(file, groups, share->format);
  if (file.has(group_names)) {
    for (const PetscInt letter : whole_list(file, group_names, share->format))
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

}  // namespace

int corners_below(const CellShape &shape, std::size_t dimension) {
  for (const CellShape *facet = shape.facet; facet; facet = facet->facet) {
    if (static_cast<std::size_t>(facet->dimension) == dimension) return facet->corners;
  }
  return 0;
}

FileShare read_share(const std::string &path, PetscInt rank, PetscInt ranks) {
  using namespace hdf5_names;
  const Hdf5Reader file(path);
  FileShare share;
  const ShareReader shares(file, rank, ranks, &share);
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

}  // namespace trefoil
