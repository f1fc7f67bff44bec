// The mesh on several ranks: every cell and vertex once, whatever divides it, and refined where
// asked. Needs petsc_main.cpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/mesh.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Point = std::array<double, 3>;
/// A cell by its corners' positions: the first as it comes, so that orientation shows.
using Cell = std::array<Point, 4>;

/// The same numbers of all ranks, one rank's after the other's, on every rank.
template <class T>
std::vector<T> gather(const std::vector<T> &mine, MPI_Datatype type) {
  int ranks = 1, count = static_cast<int>(mine.size());
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  std::vector<int> counts(static_cast<std::size_t>(ranks)), offsets(counts.size(), 0);
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, PETSC_COMM_WORLD);
  for (std::size_t r = 1; r < counts.size(); ++r) offsets[r] = offsets[r - 1] + counts[r - 1];
  std::vector<T> all(static_cast<std::size_t>(offsets.back() + counts.back()));
  MPI_Allgatherv(mine.data(), count, type, all.data(), counts.data(), offsets.data(), type,
                 PETSC_COMM_WORLD);
  return all;
}

std::vector<Cell> cells_of(const std::vector<PetscInt> &cells, const std::vector<double> &points) {
  std::vector<Cell> list(cells.size() / 4);
  for (std::size_t k = 0; k < cells.size(); ++k)
    for (std::size_t i = 0; i < 3; ++i)
      list[k / 4][k % 4][i] = points[static_cast<std::size_t>(3 * cells[k]) + i];
  return list;
}

/// All ranks' cells, in an order of their own.
std::vector<Cell> all_cells(const Mesh &mesh) {
  std::vector<double> mine;
  for (const Cell &cell : cells_of(mesh.cells, mesh.coordinates))
    for (const Point &p : cell) mine.insert(mine.end(), p.begin(), p.end());
  const std::vector<double> numbers = gather(mine, MPI_DOUBLE);
  std::vector<Cell> all(numbers.size() / 12);
  for (std::size_t k = 0; k < numbers.size(); ++k) all[k / 12][k % 12 / 3][k % 3] = numbers[k];
  std::sort(all.begin(), all.end());
  return all;
}

double volume(const Cell &x) {
  double volume = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    volume += (x[1][i] - x[0][i]) * ((x[2][j] - x[0][j]) * (x[3][k] - x[0][k]) -
                                     (x[2][k] - x[0][k]) * (x[3][j] - x[0][j]));
  }
  return volume / 6;
}

/// Vertices are owned once, by consecutive numbers, and the ghosts' numbers are their owners'.
void expect_numbering(const Mesh &mesh) {
  ASSERT_EQ(mesh.global_vertex.size(), mesh.owned.size());
  ASSERT_EQ(mesh.coordinates.size(), 3 * mesh.owned.size());
  std::vector<PetscInt> mine;
  std::vector<double> positions;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    mine.push_back(mesh.global_vertex[v]);
    positions.insert(positions.end(), &mesh.coordinates[3 * v], &mesh.coordinates[3 * v] + 3);
  }
  const std::vector<PetscInt> all = gather(mine, MPIU_INT);
  const std::vector<double> where = gather(positions, MPI_DOUBLE);
  ASSERT_EQ(all.size(), static_cast<std::size_t>(mesh.total_vertices));
  for (std::size_t v = 0; v < all.size(); ++v) ASSERT_EQ(all[v], v);
  for (std::size_t v = 0; v < mesh.owned.size(); ++v)
    for (std::size_t i = 0; i < 3; ++i)
      ASSERT_EQ(where[static_cast<std::size_t>(3 * mesh.global_vertex[v]) + i],
                mesh.coordinates[3 * v + i]);
}

struct Way {
  const char *mesh;
  PetscInt resolution;
  const char *partitioner;
};

class DistributeTest : public testing::TestWithParam<Way> {
 protected:
  void SetUp() override {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
    MPI_Comm_size(PETSC_COMM_WORLD, &ranks_);
    whole_ = generate_mesh(GetParam().mesh, GetParam().resolution, 0);
  }
  /// Only the first rank brings the mesh.
  PetscErrorCode distribute(PetscInt refine) {
    PetscFunctionBeginUser;
    PetscCall(distribute_mesh(PETSC_COMM_WORLD, rank_ == 0 ? whole_ : CellList{},
                              GetParam().partitioner, refine, &mesh_));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  int rank_ = 0, ranks_ = 1;
  CellList whole_;
  Mesh mesh_;
};

INSTANTIATE_TEST_SUITE_P(Ways, DistributeTest,
                         testing::Values(Way{"box", 1, "metis"}, Way{"box", 4, "metis"},
                                         Way{"knot", 1, "metis"}, Way{"knot", 1, "ptscotch"},
                                         Way{"box", 4, "ptscotch"}, Way{"box", 4, "simple"}),
                         [](const auto &each) {
                           return std::string(each.param.mesh) + "_" +
                                  std::to_string(each.param.resolution) + "_" +
                                  each.param.partitioner;
                         });

TEST_P(DistributeTest, EveryCellAndVertexIsThereOnce) {
  ASSERT_EQ(distribute(0), PETSC_SUCCESS);
  EXPECT_GT(mesh_.local_cells(), 0);
  EXPECT_EQ(mesh_.total_cells, whole_.size());
  EXPECT_EQ(mesh_.total_vertices, whole_.vertices());
  std::vector<Cell> expected = cells_of(whole_.cells, whole_.coordinates);
  std::sort(expected.begin(), expected.end());
  EXPECT_TRUE(all_cells(mesh_) == expected);  // also the order of the corners
  expect_numbering(mesh_);
}

TEST_P(DistributeTest, TheBoxIsThatOfTheWholeMesh) {
  ASSERT_EQ(distribute(0), PETSC_SUCCESS);
  for (std::size_t i = 0; i < 3; ++i) {
    double low = 1e9, high = -1e9;
    for (std::size_t k = i; k < whole_.coordinates.size(); k += 3) {
      low = std::min(low, whole_.coordinates[k]);
      high = std::max(high, whole_.coordinates[k]);
    }
    EXPECT_EQ(mesh_.box_min[i], low);
    EXPECT_EQ(mesh_.box_max[i], high);
  }
}

TEST_P(DistributeTest, ThePartsAreEvenAndTheCutIsCounted) {
  ASSERT_EQ(distribute(0), PETSC_SUCCESS);
  const std::vector<PetscInt> sizes = gather(std::vector{mesh_.local_cells()}, MPIU_INT);
  const double mean = static_cast<double>(whole_.size()) / ranks_;
  EXPECT_NEAR(mesh_.imbalance,
              static_cast<double>(*std::max_element(sizes.begin(), sizes.end())) / mean, 1e-12);
  if (whole_.size() > 100 && GetParam().partitioner != std::string("simple")) {
    EXPECT_LT(mesh_.imbalance, 1.1);
  }
  // A face of one cell only is on the boundary of this rank's part.
  std::multiset<std::array<PetscInt, 3>> faces;
  for (std::size_t c = 0; c < mesh_.cells.size(); c += 4)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      std::array<PetscInt, 3> face{};
      for (std::size_t i = 0; i < 3; ++i)
        face[i] =
            mesh_.global_vertex[static_cast<std::size_t>(mesh_.cells[c + (opposite + i + 1) % 4])];
      std::sort(face.begin(), face.end());
      faces.insert(face);
    }
  std::vector<PetscInt> single;
  for (const auto &face : faces)
    if (faces.count(face) == 1) single.insert(single.end(), face.begin(), face.end());
  const std::vector<PetscInt> all = gather(single, MPIU_INT);
  std::multiset<std::array<PetscInt, 3>> outer;
  for (std::size_t k = 0; k < all.size(); k += 3) outer.insert({all[k], all[k + 1], all[k + 2]});
  PetscInt cut = 0;
  for (const auto &face : outer) cut += outer.count(face) == 2;
  EXPECT_EQ(mesh_.edge_cut, cut / 2);
}

TEST_P(DistributeTest, RefinementMakesEightOfOne) {
  ASSERT_EQ(distribute(1), PETSC_SUCCESS);
  EXPECT_EQ(mesh_.total_cells, 8 * whole_.size());
  std::set<std::pair<PetscInt, PetscInt>> edges;
  double before = 0, after = 0;
  for (const Cell &cell : cells_of(whole_.cells, whole_.coordinates)) before += volume(cell);
  for (std::size_t c = 0; c < whole_.cells.size(); c += 4)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < a; ++b)
        edges.insert(std::minmax(whole_.cells[c + a], whole_.cells[c + b]));
  // One new vertex on every edge, also on those between ranks.
  EXPECT_EQ(mesh_.total_vertices, whole_.vertices() + static_cast<PetscInt>(edges.size()));
  const std::vector<Cell> cells = all_cells(mesh_);
  for (const Cell &cell : cells) {
    EXPECT_GT(volume(cell), 0);
    after += volume(cell);
  }
  EXPECT_NEAR(after / before, 1, 1e-12);
  EXPECT_TRUE(std::adjacent_find(cells.begin(), cells.end()) == cells.end());
  expect_numbering(mesh_);
}

/// Whether p lies in a tetrahedron.
bool contains(const Cell &cell, const Point &p) {
  for (std::size_t a = 0; a < 4; ++a) {
    Cell part = cell;
    part[a] = p;
    if (!(volume(part) > 0)) return false;
  }
  return true;
}

/// Every cell is a group of its own here, so that none can be taken for another.
TEST_P(DistributeTest, GroupsStayWithTheirCells) {
  Groups &groups = whole_.groups;
  for (PetscInt c = 0; c < whole_.size(); ++c)
    groups.set_of_cell.push_back(groups.set_of(3, c + 1));
  groups.name(0, "first one");
  order_along_curve(whole_);
  const std::vector<Cell> cells = cells_of(whole_.cells, whole_.coordinates);
  std::vector<Cell> cell_of_group(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c)
    cell_of_group[static_cast<std::size_t>(groups.set_of_cell[c]) - 1] = cells[c];
  for (const PetscInt refine : {0, 1}) {
    Mesh mesh;
    ASSERT_EQ(distribute_mesh(PETSC_COMM_WORLD, rank_ == 0 ? whole_ : CellList{},
                              GetParam().partitioner, refine, &mesh),
              PETSC_SUCCESS);
    ASSERT_EQ(mesh.groups.list().size(), cells.size());
    EXPECT_EQ(mesh.groups.list()[0].name, "first one");
    EXPECT_EQ(mesh.groups.list()[3].number, 4);
    EXPECT_EQ(mesh.groups.list()[3].count, refine ? 8 : 1);
    const std::vector<Cell> local = cells_of(mesh.cells, mesh.coordinates);
    ASSERT_EQ(mesh.groups.set_of_cell.size(), local.size());
    for (std::size_t c = 0; c < local.size(); ++c) {
      Point centre{};
      for (const Point &corner : local[c])
        for (std::size_t i = 0; i < 3; ++i) centre[i] += corner[i] / 4;
      const auto group = static_cast<std::size_t>(mesh.groups.set_of_cell[c]);
      ASSERT_TRUE(contains(cell_of_group[group - 1], centre)) << refine << ' ' << c;
    }
  }
}

/// The curve's order is the same with groups and without, and takes them along.
TEST(GroupTest, TheCurveTakesThemAlong) {
  CellList plain = generate_mesh("ball", 2, 0), grouped = plain;
  for (PetscInt c = 0; c < plain.size(); ++c) grouped.groups.set_of_cell.push_back(c);
  number_as_in_file(grouped);
  const std::vector<Cell> before = cells_of(plain.cells, plain.coordinates);
  order_along_curve(plain);
  order_along_curve(grouped);
  EXPECT_EQ(grouped.cells, plain.cells);
  EXPECT_TRUE(plain.groups.set_of_cell.empty());
  EXPECT_EQ(grouped.cell_number, grouped.groups.set_of_cell);
  const std::vector<Cell> after = cells_of(grouped.cells, grouped.coordinates);
  for (std::size_t c = 0; c < after.size(); ++c)
    ASSERT_TRUE(after[c] == before[static_cast<std::size_t>(grouped.groups.set_of_cell[c])]) << c;
}

TEST(PartitionerTest, UnknownNamesAreErrorsOnAllRanks) {
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks == 1) GTEST_SKIP() << "nothing is divided";
  Mesh mesh;
  ASSERT_EQ(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), PETSC_SUCCESS);
  EXPECT_EQ(distribute_mesh(PETSC_COMM_WORLD, generate_mesh("box", 2, 0), "metiss", 0, &mesh),
            PETSC_ERR_USER_INPUT);
  EXPECT_EQ(PetscPopErrorHandler(), PETSC_SUCCESS);
}

TEST(PartitionerTest, MoreRanksThanCellsIsAnError) {
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const CellList one{&shapes::tet4, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 1, 2, 3}};
  Mesh mesh;
  ASSERT_EQ(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), PETSC_SUCCESS);
  EXPECT_EQ(distribute_mesh(PETSC_COMM_WORLD, one, "metis", 0, &mesh),
            ranks > 1 ? PETSC_ERR_USER_INPUT : PETSC_SUCCESS);
  EXPECT_EQ(PetscPopErrorHandler(), PETSC_SUCCESS);
}

/// Boxes side by side with gaps between them, their vertices and cells shuffled together.
CellList boxes(PetscInt count) {
  const CellList box = generate_mesh("box", 2, 0);
  CellList all;
  for (PetscInt vertex = 0; vertex < box.vertices(); ++vertex)
    for (PetscInt b = 0; b < count; ++b)
      for (PetscInt i = 0; i < 3; ++i)
        all.coordinates.push_back(box.coordinates[static_cast<std::size_t>(3 * vertex + i)] +
                                  (i == 0 ? 1.5 * static_cast<double>(b) : 0));
  for (std::size_t c = 0; c < box.cells.size(); c += 4)
    for (PetscInt b = 0; b < count; ++b)
      for (std::size_t a = 0; a < 4; ++a) all.cells.push_back(count * box.cells[c + a] + b);
  return all;
}

TEST(ComponentsTest, EveryBoxIsOne) {
  for (const PetscInt expected : {1, 2, 5}) {
    Mesh mesh;
    std::vector<PetscInt> component;
    PetscInt count = 0;
    ASSERT_EQ(distribute_mesh(PETSC_COMM_WORLD, boxes(expected), "metis", 0, &mesh), PETSC_SUCCESS);
    ASSERT_EQ(connected_components(mesh, &component, &count), PETSC_SUCCESS);
    EXPECT_EQ(count, expected);
    ASSERT_EQ(component.size(), static_cast<std::size_t>(mesh.local_vertices()));
    std::vector<PetscInt> number_of_box(static_cast<std::size_t>(expected), -1);
    for (std::size_t v = 0; v < component.size(); ++v) {
      EXPECT_TRUE(0 <= component[v] && component[v] < expected);
      PetscInt &number =
          number_of_box[static_cast<std::size_t>(std::floor(mesh.coordinates[3 * v] / 1.5))];
      if (number < 0) number = component[v];
      EXPECT_EQ(component[v], number);
    }
    // The same box has the same number on every rank, and no two boxes share one.
    MPI_Allreduce(MPI_IN_PLACE, number_of_box.data(), static_cast<int>(expected), MPIU_INT, MPI_MAX,
                  PETSC_COMM_WORLD);
    for (std::size_t v = 0; v < component.size(); ++v)
      EXPECT_EQ(component[v],
                number_of_box[static_cast<std::size_t>(std::floor(mesh.coordinates[3 * v] / 1.5))]);
    EXPECT_EQ(std::set<PetscInt>(number_of_box.begin(), number_of_box.end()).size(),
              static_cast<std::size_t>(expected));
  }
}

// Boxes that share a vertex hang together by it.
TEST(ComponentsTest, OneSharedVertexIsEnough) {
  CellList two{&shapes::tet4,
               {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, -1, 0, 0, 0, -1},
               {0, 1, 2, 3, 0, 5, 4, 6}};
  int ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  if (ranks > 2) GTEST_SKIP() << "two cells for three ranks";
  Mesh mesh;
  std::vector<PetscInt> component;
  PetscInt count = 0;
  ASSERT_EQ(distribute_mesh(PETSC_COMM_WORLD, two, "metis", 0, &mesh), PETSC_SUCCESS);
  ASSERT_EQ(connected_components(mesh, &component, &count), PETSC_SUCCESS);
  EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace trefoil
