#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "mesh/check_mesh.hpp"
#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil {
namespace {

// Five tetrahedra over one frame: good, negative, flat, with a repeated vertex, good.
CellList mixed_mesh(double unit = 1) {
  CellList mesh;
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0};
  mesh.cells = {0, 1, 2, 3, 0, 2, 1, 3, 0, 1, 2, 4, 0, 1, 1, 3, 1, 4, 2, 3};
  for (double &coordinate : mesh.coordinates) coordinate *= unit;
  return mesh;
}

std::string refusal(CellList mesh, Repair repair) {
  try {
    repair_rest_shape(mesh, repair, "horse.mesh");
  } catch (const InputError &error) {
    return error.what();
  }
  return "";
}

// A tetrahedron of the given height over a triangle with edges of about 1.
CellList flat_tetrahedron(double height, double unit) {
  CellList mesh;
  mesh.coordinates = {0, 0, 0, unit, 0, 0, 0, unit, 0, 0, 0, height * unit};
  mesh.cells = {0, 1, 2, 3};
  return mesh;
}

TEST(CheckMesh, CountsEachKindInAnyUnit) {
  for (const double unit : {1e-300, 1e-150, 1., 1e100, 1e307}) {
    const RestCheck check = check_rest_shape(mixed_mesh(unit));
    EXPECT_EQ(check.degenerate, 2) << unit;
    EXPECT_EQ(check.negative, 1) << unit;
    EXPECT_EQ(check.first, 2) << unit;
  }
}

TEST(CheckMesh, DegenerateMeansFlatInProportionToTheLongestEdge) {
  const double threshold = 1e-14 * std::pow(2, 1.5);  // (longest edge)^3 = sqrt(2)^3
  for (const double unit : {1e-150, 1., 1e100}) {
    EXPECT_EQ(check_rest_shape(flat_tetrahedron(1.01 * threshold, unit)).bad(), 0) << unit;
    EXPECT_EQ(check_rest_shape(flat_tetrahedron(-1.01 * threshold, unit)).negative, 1) << unit;
    EXPECT_EQ(check_rest_shape(flat_tetrahedron(0.99 * threshold, unit)).degenerate, 1) << unit;
    EXPECT_EQ(check_rest_shape(flat_tetrahedron(-0.99 * threshold, unit)).degenerate, 1) << unit;
  }
}

TEST(CheckMesh, RefusalNamesCountsFirstAndTheWayOut) {
  EXPECT_EQ(refusal(mixed_mesh(), Repair::none),
            "horse.mesh: 2 tetrahedra are degenerate and 1 tetrahedron is of negative volume, the "
            "first is tetrahedron 2 (tetrahedron 2 is tetrahedron 1 turned round); mend the mesh, "
            "or leave "
            "them out with -mesh_repair drop");
}

TEST(CheckMesh, DropKeepsTheRestInOrder) {
  CellList mesh = mixed_mesh();
  EXPECT_EQ(repair_rest_shape(mesh, Repair::drop, "horse.mesh").dropped, 3);
  EXPECT_EQ(mesh.cells, (std::vector<PetscInt>{0, 1, 2, 3, 1, 4, 2, 3}));
  EXPECT_EQ(repair_rest_shape(mesh, Repair::none, "horse.mesh").dropped, 0);
}

TEST(CheckMesh, MeshTurnedRoundIsTurnedBack) {
  CellList mesh = generate_mesh("box", 2, 0);
  const CellList right = mesh;
  const auto turned = [&] {
    CellList other = right;
    for (std::size_t c = 0; c < other.cells.size(); c += 4)
      std::swap(other.cells[c + 1], other.cells[c + 2]);
    return other;
  };
  mesh = turned();
  const RepairReport report = repair_rest_shape(mesh, Repair::none, "box");
  EXPECT_EQ(report.turned, 48);
  EXPECT_EQ(report.dropped, 0);
  EXPECT_EQ(mesh.cells, right.cells);
  // Flat cells are neither way round.
  mesh = turned();
  mesh.cells.insert(mesh.cells.end(), {0, 1, 2, 3});
  EXPECT_EQ(repair_rest_shape(mesh, Repair::drop, "box").turned, 48);
  EXPECT_EQ(mesh.cells, right.cells);
  // Quadratic ones are turned with their midpoints.
  mesh = turned();
  promote_to_quadratic(mesh);
  EXPECT_EQ(repair_rest_shape(mesh, Repair::none, "box").turned, 48);
  CellList quadratic = right;
  promote_to_quadratic(quadratic);
  EXPECT_EQ(mesh.cells, quadratic.cells);
  // One of many is no mesh the other way round.
  mesh = right;
  std::swap(mesh.cells[0], mesh.cells[1]);
  EXPECT_NE(refusal(mesh, Repair::none).find("1 tetrahedron is of negative volume"),
            std::string::npos);
}

TEST(CheckMesh, NothingLeftIsRefused) {
  CellList mesh = mixed_mesh();
  mesh.cells = {0, 1, 2, 4};
  EXPECT_NE(refusal(mesh, Repair::drop).find("nothing is left"), std::string::npos);
  mesh.cells.clear();
  EXPECT_NE(refusal(mesh, Repair::drop).find("no tetrahedra"), std::string::npos);
}

/// What is left out inside of a body leaves a hole; a cell that has collapsed to a face leaves
/// none.
TEST(CheckMesh, HolesAreCounted) {
  CellList mesh = generate_mesh("box", 3, 0);
  std::swap(mesh.cells[4 * 80], mesh.cells[4 * 80 + 1]);  // in the middle cube
  RepairReport report = repair_rest_shape(mesh, Repair::drop, "box");
  EXPECT_EQ(report.dropped, 1);
  EXPECT_EQ(report.opened, 4);
  // In a corner of the cube, with two faces on its surface.
  mesh = generate_mesh("box", 1, 0);
  std::swap(mesh.cells[0], mesh.cells[1]);
  EXPECT_EQ(repair_rest_shape(mesh, Repair::drop, "box").opened, 2);
  // Two cells face to face, and between them one that has no volume and the face twice.
  mesh.coordinates = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1};
  mesh.cells = {0, 1, 2, 3, 0, 2, 1, 4, 0, 1, 2, 0};
  report = repair_rest_shape(mesh, Repair::drop, "two");
  EXPECT_EQ(report.dropped, 1);
  EXPECT_EQ(report.opened, 0);
}

TEST(CheckMesh, DropsUnusedVertices) {
  CellList mesh = mixed_mesh();
  mesh.cells = {4, 1, 3, 2};
  EXPECT_EQ(drop_unused_vertices(mesh), 1);
  EXPECT_EQ(mesh.cells, (std::vector<PetscInt>{3, 0, 2, 1}));
  EXPECT_EQ(mesh.coordinates, (std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0}));
  EXPECT_EQ(drop_unused_vertices(mesh), 0);
}

TEST(CheckMesh, NormalizeCentresAndScales) {
  for (const double unit : {1e-300, 1., 1e307}) {
    CellList mesh = mixed_mesh(unit);
    normalize(mesh);
    double largest = 0;
    for (std::size_t component = 0; component < 3; ++component) {
      double sum = 0;
      for (std::size_t vertex = 0; vertex < 5; ++vertex)
        sum += mesh.coordinates[3 * vertex + component];
      EXPECT_NEAR(sum, 0, 1e-15);
    }
    for (std::size_t vertex = 0; vertex < 5; ++vertex) {
      const double *x = &mesh.coordinates[3 * vertex];
      largest = std::max(largest, std::hypot(x[0], x[1], x[2]));
    }
    EXPECT_NEAR(largest, 1, 1e-15);
    // The mean is (0.4, 0.4, 0.2), the farthest vertex (0, 0, 1).
    EXPECT_NEAR(mesh.coordinates[11], 0.8 / std::hypot(0.4, 0.4, 0.8), 1e-15);
  }
}

TEST(CheckMesh, NormalizeRefusesAPoint) {
  CellList mesh;
  EXPECT_THROW(normalize(mesh), InputError);
  mesh.coordinates = {0.1, 0.2, 0.3, 0.1, 0.2, 0.3, 0.1, 0.2, 0.3};
  EXPECT_THROW(normalize(mesh), InputError);
}

/// Corners of each tetrahedron by their positions, in a canonical order: what a mesh is, whatever
/// its numbering.
std::vector<std::vector<double>> shapes(const CellList &mesh) {
  std::vector<std::vector<double>> all;
  for (std::size_t c = 0; c < mesh.cells.size(); c += 4) {
    std::vector<double> shape;
    for (std::size_t a = 0; a < 4; ++a) {
      const auto first = mesh.coordinates.begin() + 3 * mesh.cells[c + a];
      shape.insert(shape.end(), first, first + 3);
    }
    all.push_back(shape);
  }
  std::sort(all.begin(), all.end());
  return all;
}

/// Mean distance in memory between the corners of a tetrahedron.
double mean_spread(const CellList &mesh) {
  double sum = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); c += 4) {
    const auto [least, most] = std::minmax_element(&mesh.cells[c], &mesh.cells[c] + 4);
    sum += *most - *least;
  }
  return sum / static_cast<double>(mesh.size());
}

TEST(Locality, KeepsTheMeshAndBringsNeighboursTogether) {
  CellList mesh = generate_mesh("ball", 6, 0);
  // As a mesher might leave it: vertices in no order at all.
  std::mt19937 random(5);
  std::vector<PetscInt> shuffled(static_cast<std::size_t>(mesh.vertices()));
  std::iota(shuffled.begin(), shuffled.end(), 0);
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  CellList mixed = mesh;
  for (std::size_t v = 0; v < shuffled.size(); ++v) {
    std::copy_n(&mesh.coordinates[3 * v], 3,
                &mixed.coordinates[3 * static_cast<std::size_t>(shuffled[v])]);
  }
  for (PetscInt &corner : mixed.cells) corner = shuffled[static_cast<std::size_t>(corner)];
  CellList ordered = mixed;
  order_along_curve(ordered);
  EXPECT_EQ(shapes(ordered), shapes(mesh)) << "corners keep their order within each cell";
  EXPECT_LT(mean_spread(ordered), 0.3 * mean_spread(mixed));
  CellList again = ordered;
  order_along_curve(again);
  EXPECT_EQ(again.cells, ordered.cells);
}

/// Vertices of two bodies that are not one count once each, wherever the curve's grid cuts.
TEST(Locality, CoincidentVerticesAreCounted) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const double distance : {0., 3e-10, 1e-7}) {
    CellList mesh = generate_mesh("box", 5, 0);
    for (double &x : mesh.coordinates) x = x * 3 - 1;
    const CellList once = mesh;
    const PetscInt vertices = mesh.vertices();
    mesh.cells.insert(mesh.cells.end(), once.cells.begin(), once.cells.end());
    for (std::size_t k = once.cells.size(); k < mesh.cells.size(); ++k) mesh.cells[k] += vertices;
    for (const double x : once.coordinates)
      mesh.coordinates.push_back(x + distance * uniform(random));
    order_along_curve(mesh);
    EXPECT_EQ(coincident_vertices(mesh), distance < 1e-8 ? vertices : 0) << distance;
  }
  CellList alone = generate_mesh("knot", 1, 0);
  order_along_curve(alone);
  EXPECT_EQ(coincident_vertices(alone), 0);
}

}  // namespace
}  // namespace trefoil
