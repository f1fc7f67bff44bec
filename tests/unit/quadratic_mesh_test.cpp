// Midpoints, uniform refinement, plane meshes, and cells that are bent too far.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "element/bent_cells.hpp"
#include "element/isoparametric_element.hpp"
#include "mesh/check_mesh.hpp"
#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"
#include "mesh/refine.hpp"

namespace trefoil {
namespace {

struct Sizes {
  double volume = 0, least_jacobian = 1e300;
};

Sizes measure(const CellList &mesh) {
  Sizes sizes;
  const ReferenceElement &reference = reference_element(mesh.dimension(), mesh.nodes_per_cell());
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    std::vector<double> position;
    for (std::size_t a = 0; a < width; ++a) {
      const double *p = &mesh.coordinates[static_cast<std::size_t>(3 * mesh.cells[c + a])];
      position.insert(position.end(), p, p + 3);
    }
    const IsoparametricElement element(reference, position.data());
    for (int q = 0; q < reference.points; ++q) sizes.volume += element.weight(q);
    sizes.least_jacobian = std::min(sizes.least_jacobian, element.least_jacobian());
  }
  return sizes;
}

class QuadraticMeshTest : public testing::TestWithParam<const char *> {
 protected:
  const CellList linear_ = generate_mesh(GetParam(), 3, 0);
};

TEST_P(QuadraticMeshTest, MidpointsAreSharedAndInTheMiddle) {
  CellList mesh = linear_;
  promote_to_quadratic(mesh);
  EXPECT_EQ(mesh.shape->order, 2);
  EXPECT_EQ(mesh.size(), linear_.size());
  std::set<std::pair<PetscInt, PetscInt>> edges;
  const auto corners = static_cast<std::size_t>(linear_.corners());
  for (std::size_t c = 0; c < linear_.cells.size(); c += corners)
    for (std::size_t a = 0; a < corners; ++a)
      for (std::size_t b = 0; b < a; ++b)
        edges.insert(std::minmax(linear_.cells[c + a], linear_.cells[c + b]));
  EXPECT_EQ(mesh.vertices(), linear_.vertices() + static_cast<PetscInt>(edges.size()));
  const Sizes before = measure(linear_), after = measure(mesh);
  EXPECT_NEAR(after.volume / before.volume, 1, 1e-13);
  EXPECT_NEAR(after.least_jacobian / before.least_jacobian, 1, 1e-12);  // straight: constant
  drop_midpoints(mesh);
  drop_unused_vertices(mesh);
  EXPECT_EQ(mesh.cells, linear_.cells);
  EXPECT_EQ(mesh.coordinates, linear_.coordinates);
}

TEST_P(QuadraticMeshTest, RefinementKeepsTheVolumeAndHalvesTheEdges) {
  CellList mesh = linear_;
  refine_uniformly(mesh);
  EXPECT_EQ(mesh.shape->order, 1);
  EXPECT_EQ(mesh.size(), mesh.shape->children * linear_.size());
  EXPECT_EQ(check_rest_shape(mesh).bad(), 0);
  EXPECT_NEAR(measure(mesh).volume / measure(linear_).volume, 1, 1e-13);
  // Conforming: every face inside belongs to two cells, so that a second refinement shares
  // midpoints.
  CellList promoted = linear_;
  promote_to_quadratic(promoted);
  EXPECT_EQ(mesh.vertices(), promoted.vertices());
}

TEST_P(QuadraticMeshTest, ChildrenAreInTheirParentsGroup) {
  CellList mesh = linear_;
  Groups &groups = mesh.groups;
  for (PetscInt c = 0; c < mesh.size(); ++c)
    groups.set_of_cell.push_back(groups.set_of({groups.add(mesh.dimension(), 1 + c % 3)}));
  std::map<PetscInt, double> before, after;  // the volume of each group
  const auto add_up = [](const CellList &list, std::map<PetscInt, double> &volumes) {
    ASSERT_EQ(list.groups.set_of_cell.size(), static_cast<std::size_t>(list.size()));
    CellList alone{list.shape, list.coordinates, {}};
    for (PetscInt c = 0; c < list.size(); ++c) {
      const auto cell = list.cells.begin() + c * list.nodes_per_cell();
      alone.cells.assign(cell, cell + list.nodes_per_cell());
      volumes[list.groups.set_of_cell[static_cast<std::size_t>(c)]] += measure(alone).volume;
    }
  };
  add_up(mesh, before);
  refine_uniformly(mesh);
  add_up(mesh, after);
  ASSERT_EQ(before.size(), 3u);
  for (const auto &[group, volume] : before) EXPECT_NEAR(after[group] / volume, 1, 1e-12) << group;
}

TEST_P(QuadraticMeshTest, OrderAlongTheCurveIsTheSameMesh) {
  CellList mesh = linear_;
  promote_to_quadratic(mesh);
  const Sizes before = measure(mesh);
  order_along_curve(mesh);
  const Sizes after = measure(mesh);
  EXPECT_NEAR(after.volume / before.volume, 1, 1e-13);
  EXPECT_EQ(after.least_jacobian, before.least_jacobian);
}

TEST_P(QuadraticMeshTest, CellsThatAreBentTooFarAreFound) {
  CellList mesh = linear_;
  promote_to_quadratic(mesh);
  const ReferenceElement &reference = reference_element(mesh.dimension(), mesh.nodes_per_cell());
  EXPECT_EQ(first_bent_cell(reference, mesh.coordinates, mesh.cells), -1);
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  const auto corners = static_cast<std::size_t>(mesh.corners());
  // The first midpoint of the sixth cell goes to the opposite corner and beyond.
  const PetscInt midpoint = mesh.cells[5 * width + corners], corner = mesh.cells[5 * width + 2];
  for (std::size_t i = 0; i < 3; ++i) {
    double &x = mesh.coordinates[static_cast<std::size_t>(3 * midpoint) + i];
    x += 1.5 * (mesh.coordinates[static_cast<std::size_t>(3 * corner) + i] - x);
  }
  const PetscInt bent = first_bent_cell(reference, mesh.coordinates, mesh.cells);
  ASSERT_GE(bent, 0);
  CellList alone = mesh;
  const auto begin = mesh.cells.begin() + static_cast<std::ptrdiff_t>(width) * bent;
  alone.cells.assign(begin, begin + static_cast<std::ptrdiff_t>(width));
  EXPECT_LE(measure(alone).least_jacobian, 0);
}

/// The last two midpoints of a tetrahedron stand the other way round in Gmsh's order and in others.
TEST_P(QuadraticMeshTest, MidpointsInAnotherOrderAreRefused) {
  CellList mesh = linear_;
  promote_to_quadratic(mesh);
  // A little bent.
  for (std::size_t k = 3 * static_cast<std::size_t>(linear_.vertices());
       k < mesh.coordinates.size(); ++k)
    if (static_cast<int>(k % 3) < mesh.dimension())
      mesh.coordinates[k] += 0.002 * std::sin(91. * static_cast<double>(k));
  check_node_order(linear_, "linear");
  check_node_order(mesh, "right");
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  for (std::size_t cell = 3 * width; cell < mesh.cells.size(); cell += width)
    std::swap(mesh.cells[cell + width - 2], mesh.cells[cell + width - 1]);
  try {
    check_node_order(mesh, "wrong");
    FAIL() << "accepted";
  } catch (const InputError &error) {
    const std::string sentence = error.what();
    const std::string expected =
        mesh.dimension() == 2
            ? "wrong: triangle 4 has its midpoints in another order than Gmsh: its node 5 lies "
              "between corners 3 and 1, where node 6 belongs"
            : "wrong: tetrahedron 4 has its midpoints in another order than Gmsh: its node 10 lies "
              "between corners 3 and 4, where node 9 belongs";
    EXPECT_EQ(sentence.substr(0, expected.size()), expected);
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, QuadraticMeshTest, testing::Values("square", "box", "ball"),
                         [](const auto &each) { return std::string(each.param); });

/// Of the octahedron's three diagonals the shortest becomes an edge, and no other.
TEST(RefinementTest, CutsOctahedraAlongTheirShortestDiagonal) {
  const double shapes[3][3] = {{1, -1, 0.5}, {1, 1, 0.5}, {-1, 1, 0.5}};  // the fourth corner
  std::set<std::size_t> chosen;
  for (const auto &last : shapes) {
    CellList mesh;
    mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, last[0], last[1], last[2]};
    mesh.cells = {0, 1, 2, 3};
    promote_to_quadratic(mesh);
    const std::vector<PetscInt> node = mesh.cells;
    const std::vector<double> x = mesh.coordinates;
    mesh.cells = {0, 1, 2, 3};
    mesh.coordinates.resize(12);
    mesh.shape = &shapes::tet4;
    refine_uniformly(mesh);
    ASSERT_EQ(mesh.coordinates, x);
    const std::size_t diagonals[3][2] = {{4, 9}, {5, 7}, {6, 8}};  // midpoints of opposite edges
    double lengths[3] = {};
    bool found[3] = {};
    for (std::size_t d = 0; d < 3; ++d) {
      const PetscInt a = node[diagonals[d][0]], b = node[diagonals[d][1]];
      for (std::size_t i = 0; i < 3; ++i)
        lengths[d] += std::pow(
            x[static_cast<std::size_t>(3 * a) + i] - x[static_cast<std::size_t>(3 * b) + i], 2);
      for (auto cell = mesh.cells.begin(); cell != mesh.cells.end(); cell += 4)
        found[d] = found[d] || (std::count(cell, cell + 4, a) && std::count(cell, cell + 4, b));
    }
    const auto shortest =
        static_cast<std::size_t>(std::min_element(lengths, lengths + 3) - lengths);
    for (std::size_t d = 0; d < 3; ++d) EXPECT_EQ(found[d], d == shortest) << d;
    chosen.insert(shortest);
  }
  EXPECT_EQ(chosen.size(), 3u);
}

TEST(PlaneMesh, TrianglesAreTurnedAnticlockwise) {
  CellList mesh = generate_mesh("square", 2, 0);
  std::swap(mesh.cells[1], mesh.cells[2]);
  EXPECT_EQ(check_rest_shape(mesh).negative, 1);
  EXPECT_EQ(repair_rest_shape(mesh, Repair::none, "square").dropped, 0);
  EXPECT_EQ(check_rest_shape(mesh).bad(), 0);
  promote_to_quadratic(mesh);
  std::swap(mesh.cells[1], mesh.cells[2]);
  std::swap(mesh.cells[3], mesh.cells[5]);
  EXPECT_EQ(repair_rest_shape(mesh, Repair::none, "square").dropped, 0);
  EXPECT_NEAR(measure(mesh).volume, 1, 1e-14);
}

TEST(PlaneMesh, SurfacesInSpaceAreRefused) {
  CellList mesh = generate_mesh("square", 2, 0);
  mesh.coordinates[5] = 0.1;
  try {
    repair_rest_shape(mesh, Repair::none, "shell");
    FAIL() << "accepted";
  } catch (const InputError &error) {
    EXPECT_NE(std::string(error.what()).find("plane z = 0"), std::string::npos) << error.what();
  }
}

TEST(PlaneMesh, FlatTrianglesAreDropped) {
  CellList mesh = generate_mesh("square", 2, 0);
  mesh.cells.insert(mesh.cells.end(), {0, 1, 2});
  EXPECT_EQ(check_rest_shape(mesh).degenerate, 1);
  EXPECT_EQ(repair_rest_shape(mesh, Repair::drop, "square").dropped, 1);
  EXPECT_EQ(mesh.size(), 8);
}

TEST(PlaneMesh, SquareOfTheProjectedNewtonText) {
  const CellList mesh = generate_mesh("square", 100, 0);
  EXPECT_EQ(mesh.vertices(), 10201);
  EXPECT_EQ(mesh.size(), 20000);
  EXPECT_EQ(check_rest_shape(mesh).bad(), 0);
  EXPECT_NEAR(measure(mesh).volume, 1, 1e-12);
}

}  // namespace
}  // namespace trefoil
