// Groups of points, curves, surfaces and volumes on several ranks: what is in them, after ordering,
// refinement and promotion to quadratic cells. Needs petsc_main.cpp.

#include "mesh/group_members.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesh/check_mesh.hpp"
#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"
#include "mesh/refine.hpp"
#include "mesh/repeated.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Point = std::array<double, 3>;
using Where = bool (*)(const Point &);

bool is_left(const Point &p) {
  return p[0] == 0;
}
bool is_low(const Point &p) {
  return p[1] == 0;
}
bool is_left_low(const Point &p) {
  return is_left(p) && is_low(p);
}
bool is_inside(const Point &p) {
  return std::abs(p[0] - 0.5) < 1e-12;
}
bool is_corner(const Point &p) {
  return is_left_low(p) && p[2] == 0;
}

double sum_over_ranks(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return value;
}

Point position(const std::vector<double> &coordinates, PetscInt vertex) {
  const double *p = &coordinates[static_cast<std::size_t>(3 * vertex)];
  return {p[0], p[1], p[2]};
}

/// Puts all entities of a shape that a cell has, and whose corners are all there, into a group.
void put(CellList &mesh, const std::vector<std::vector<int>> &entities, Where where, int dimension,
         PetscInt number, const std::string &name) {
  const int group = mesh.groups.add(dimension, number);
  mesh.groups.name(group, name);
  for (std::size_t c = 0; c < mesh.cells.size(); c += static_cast<std::size_t>(mesh.corners())) {
    for (const std::vector<int> &entity : entities) {
      std::vector<PetscInt> vertices;
      for (const int corner : entity)
        vertices.push_back(mesh.cells[c + static_cast<std::size_t>(corner)]);
      if (!std::all_of(vertices.begin(), vertices.end(),
                       [&](PetscInt v) { return where(position(mesh.coordinates, v)); }))
        continue;
      GroupedEntities &below = mesh.groups.below[static_cast<std::size_t>(dimension)];
      below.vertices.insert(below.vertices.end(), vertices.begin(), vertices.end());
      below.sets.push_back(mesh.groups.set_of({group}));
    }
  }
}

/// The unit cube or square, with groups on its left and low sides, on an edge, in a corner, across
/// its middle, and of the cells that are left of that. A side is called a surface in three
/// dimensions and a curve in two.
CellList body(const char *kind) {
  CellList mesh = generate_mesh(kind, 4, 0);
  std::vector<std::vector<int>> facets, edges;
  for (const auto &facet : mesh.shape->facets)
    facets.emplace_back(facet.begin(), facet.begin() + mesh.shape->facet->corners);
  for (const auto &edge : mesh.shape->edges) edges.emplace_back(edge.begin(), edge.end());
  const int side = mesh.dimension() - 1;
  put(mesh, facets, is_left, side, 1, "left");
  put(mesh, facets, is_low, side, 2, "low");
  put(mesh, facets, is_left, side, 3, "both");
  put(mesh, facets, is_low, side, 3, "both");
  put(mesh, facets, is_inside, side, 4, "middle");
  if (mesh.dimension() == 3) put(mesh, edges, is_left_low, 1, 1, "edge");
  put(mesh, {{0}, {1}, {2}}, is_corner, 0, 1, "corner");
  const PetscInt left_half = mesh.groups.set_of(mesh.dimension(), 8);
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    bool is_in_it = true;
    for (int a = 0; a < mesh.corners(); ++a)
      is_in_it =
          is_in_it &&
          position(mesh.coordinates,
                   mesh.cells[static_cast<std::size_t>(mesh.corners() * cell + a)])[0] < 0.51;
    mesh.groups.set_of_cell.push_back(is_in_it ? left_half : 0);
  }
  take_once(mesh, kind);
  return mesh;
}

struct Way {
  const char *name, *mesh;
  int serial_refine, refine;
  bool quadratic;
};

class GroupMembersTest : public testing::TestWithParam<Way> {
 protected:
  void SetUp() override {
    int rank = 0;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    CellList whole;
    if (rank == 0) {
      whole = body(GetParam().mesh);
      number_as_in_file(whole);
      for (int k = 0; k < GetParam().serial_refine; ++k) refine_uniformly(whole);
      if (GetParam().quadratic) promote_to_quadratic(whole);
      drop_unused_vertices(whole);
      order_along_curve(whole);
    }
    ASSERT_EQ(distribute_mesh(PETSC_COMM_WORLD, whole, "metis", GetParam().refine, &mesh_),
              PETSC_SUCCESS);
    cells_a_side_ = 4 << (GetParam().serial_refine + GetParam().refine);
  }
  [[nodiscard]] int group(const std::string &name, int dimension) const {
    return find_group(mesh_.groups, name, {&dimension, 1}, "-group");
  }
  [[nodiscard]] PetscInt count(const std::string &name, int dimension) const {
    return mesh_.groups.list()[static_cast<std::size_t>(group(name, dimension))].count;
  }
  [[nodiscard]] int side() const { return mesh_.dimension() - 1; }
  /// Facets on a side of the body.
  [[nodiscard]] int facets_a_side() const {
    return side() == 1 ? cells_a_side_ : 2 * cells_a_side_ * cells_a_side_;
  }

  void expect_vertices(int group, Where where) {
    std::vector<char> taken;
    ASSERT_EQ(vertices_of_group(mesh_, group, &taken), PETSC_SUCCESS);
    ASSERT_EQ(taken.size(), static_cast<std::size_t>(mesh_.local_vertices()));
    for (PetscInt v = 0; v < mesh_.local_vertices(); ++v)
      ASSERT_EQ(taken[static_cast<std::size_t>(v)] != 0, where(position(mesh_.coordinates, v)))
          << "vertex " << v;
  }

  /// The first component of the normal, times the area, by the corners.
  [[nodiscard]] Point area_vector(const Facet &facet) const {
    const Point a = position(mesh_.coordinates, facet.vertices[0]);
    const Point b = position(mesh_.coordinates, facet.vertices[1]);
    if (facet.shape->dimension == 1) return {b[1] - a[1], a[0] - b[0], 0};
    const Point c = position(mesh_.coordinates, facet.vertices[2]);
    Point normal;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      normal[i] = ((b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j])) / 2;
    }
    return normal;
  }

  Mesh mesh_;
  int cells_a_side_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Ways, GroupMembersTest,
                         testing::Values(Way{"tet4", "box", 0, 0, false},
                                         Way{"tet10", "box", 0, 0, true},
                                         Way{"tet4_refined_whole", "box", 1, 0, false},
                                         Way{"tet10_refined", "box", 1, 0, true},
                                         Way{"tet4_refined", "box", 0, 1, false},
                                         Way{"tet4_refined_twice", "box", 0, 2, false},
                                         Way{"tri3", "square", 0, 0, false},
                                         Way{"tri6", "square", 0, 0, true},
                                         Way{"tri3_refined", "square", 0, 2, false},
                                         Way{"tri6_refined", "square", 2, 0, true}),
                         [](const auto &each) { return std::string(each.param.name); });

TEST_P(GroupMembersTest, AllRanksKnowWhichThereAre) {
  const int facets = facets_a_side();
  EXPECT_EQ(count("left", side()), facets);
  EXPECT_EQ(count("low", side()), facets);
  EXPECT_EQ(count("both", side()), 2 * facets);
  EXPECT_EQ(count("8", mesh_.dimension()), mesh_.total_cells / 2);
  EXPECT_EQ(count("corner", 0), 1);
  if (mesh_.dimension() == 3) {
    EXPECT_EQ(count("edge", 1), cells_a_side_);
  }
}

TEST_P(GroupMembersTest, VerticesAreThoseOfTheirPlaces) {
  expect_vertices(group("left", side()), is_left);
  expect_vertices(group("low", side()), is_low);
  expect_vertices(group("both", side()), [](const Point &p) { return is_left(p) || is_low(p); });
  expect_vertices(group("corner", 0), is_corner);
  expect_vertices(group("8", mesh_.dimension()), [](const Point &p) { return p[0] < 0.51; });
  if (mesh_.dimension() == 3) expect_vertices(group("edge", 1), is_left_low);
}

TEST_P(GroupMembersTest, FacetsAreThereOnceAndFaceOutward) {
  for (const auto &[name, expected] :
       {std::pair{"left", Point{-1, 0, 0}}, {"low", {0, -1, 0}}, {"both", {-1, -1, 0}}}) {
    std::vector<Facet> facets;
    PetscInt inner = -1;
    ASSERT_EQ(facets_of_group(mesh_, group(name, side()), &facets, &inner), PETSC_SUCCESS);
    EXPECT_EQ(inner, 0);
    EXPECT_EQ(sum_over_ranks(static_cast<double>(facets.size())), count(name, side()));
    Point sum{};
    for (const Facet &facet : facets) {
      EXPECT_EQ(facet.count(), mesh_.shape->facet->nodes);
      const Point area = area_vector(facet);
      for (std::size_t i = 0; i < 3; ++i) sum[i] += area[i];
      for (std::size_t e = 0; e < facet.shape->edges.size() && GetParam().quadratic; ++e) {
        const auto &edge = facet.shape->edges[e];
        const auto middle = static_cast<std::size_t>(facet.corners()) + e;
        for (std::size_t i = 0; i < 3; ++i)
          EXPECT_DOUBLE_EQ(
              2 * position(mesh_.coordinates, facet.vertices[middle])[i],
              position(mesh_.coordinates, facet.vertices[static_cast<std::size_t>(edge[0])])[i] +
                  position(mesh_.coordinates,
                           facet.vertices[static_cast<std::size_t>(edge[1])])[i]);
      }
    }
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(sum_over_ranks(sum[i]), expected[i], 1e-12) << name;
  }
}

TEST_P(GroupMembersTest, FacetsBetweenCellsAreCountedAsInner) {
  std::vector<Facet> facets;
  PetscInt inner = -1;
  ASSERT_EQ(facets_of_group(mesh_, group("middle", side()), &facets, &inner), PETSC_SUCCESS);
  EXPECT_TRUE(facets.empty());
  EXPECT_EQ(inner, facets_a_side());
  expect_vertices(group("middle", side()), is_inside);
}

TEST_P(GroupMembersTest, NumbersAreTheFiles) {
  CellList whole = body(GetParam().mesh);
  EXPECT_EQ(mesh_.file_vertices, whole.vertices());
  PetscInt old = 0;
  for (PetscInt v = 0; v < mesh_.local_vertices(); ++v) {
    const PetscInt number = mesh_.vertex_number[static_cast<std::size_t>(v)];
    if (number >= whole.vertices()) continue;
    old += mesh_.owned[static_cast<std::size_t>(v)];
    EXPECT_EQ(position(mesh_.coordinates, v), position(whole.coordinates, number));
  }
  EXPECT_EQ(sum_over_ranks(old), whole.vertices());
}

/// A surface that is none of any cell's is in no rank's groups.
TEST(GroupsOfNoCell, AreLeftOut) {
  CellList whole = generate_mesh("box", 2, 0);
  const PetscInt set = whole.groups.set_of(2, 5);
  whole.groups.below[2] = {{0, 13, 26, 0, 1, 4}, {set, set}};  // a diagonal, and a face
  Mesh mesh;
  ASSERT_EQ(distribute_mesh(PETSC_COMM_WORLD, whole, "metis", 0, &mesh), PETSC_SUCCESS);
  EXPECT_EQ(mesh.groups.list()[0].count, 1);
}

}  // namespace
}  // namespace trefoil
