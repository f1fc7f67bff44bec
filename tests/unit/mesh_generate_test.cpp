#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "mesh/check_mesh.hpp"
#include "mesh/generate.hpp"

namespace trefoil {
namespace {

const std::vector<std::string> kinds = {"box", "cylinder", "knot", "ball"};

// By Pappus a tube's volume is its cross-section times the length of its axis.
double exact_volume(const std::string &kind) {
  if (kind == "box") return 1;
  if (kind == "cylinder") return std::numbers::pi * 0.25 * 2;
  if (kind == "ball") return std::numbers::pi / 6;
  double length = 0;
  constexpr int samples = 1000;
  for (int sample = 0; sample < samples; ++sample) {
    const double torus_radius = 2 + std::cos(6 * std::numbers::pi * sample / samples);
    length += 2 * std::numbers::pi / samples * std::hypot(3, 2 * torus_radius);
  }
  return std::numbers::pi * 0.16 * length;
}

struct Shape {
  double volume = 0;         // signed, of all tetrahedra
  double least_quality = 1;  // 1: regular, 0: flat, negative: turned round
};

// The mean ratio of a tetrahedron, 12 (3 volume)^(2/3) / (sum of squared edges). A. Liu, B. Joe,
// "Relationship between tetrahedron shape measures", BIT 34 (1994).
Shape measure(const CellList &mesh) {
  Shape shape;
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    std::array<std::array<double, 3>, 4> x;
    for (std::size_t corner = 0; corner < 4; ++corner)
      for (std::size_t k = 0; k < 3; ++k)
        x[corner][k] = mesh.coordinates[3 * mesh.cells[4 * cell + corner] + k];
    double squares = 0;
    for (std::size_t end = 0; end < 4; ++end)
      for (std::size_t start = 0; start < end; ++start)
        for (std::size_t k = 0; k < 3; ++k) squares += std::pow(x[end][k] - x[start][k], 2);
    const auto edge = [&](std::size_t end, std::size_t k) { return x[end][k] - x[0][k]; };
    double six_volumes = 0;
    for (std::size_t k = 0; k < 3; ++k)
      six_volumes += edge(1, k) * (edge(2, (k + 1) % 3) * edge(3, (k + 2) % 3) -
                                   edge(2, (k + 2) % 3) * edge(3, (k + 1) % 3));
    shape.volume += six_volumes / 6;
    const double quality = 12 * std::cbrt(six_volumes * std::abs(six_volumes) / 4) / squares;
    shape.least_quality = std::min(shape.least_quality, quality);
  }
  return shape;
}

// Every face belongs to two tetrahedra, or to one and the boundary; every edge of the boundary to
// two faces of it. Returns vertices - edges + faces of the boundary.
std::ptrdiff_t check_conformity(const CellList &mesh) {
  std::map<std::array<PetscInt, 3>, int> faces;
  for (PetscInt cell = 0; cell < mesh.size(); ++cell)
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      std::array<PetscInt, 3> face;
      for (std::size_t k = 0; k < 3; ++k) face[k] = mesh.cells[4 * cell + (opposite + 1 + k) % 4];
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  std::map<std::array<PetscInt, 2>, int> edges;
  std::map<PetscInt, int> vertices;
  std::ptrdiff_t boundary_faces = 0;
  for (const auto &[face, times] : faces) {
    EXPECT_LE(times, 2);
    if (times != 1) continue;
    ++boundary_faces;
    for (const auto &edge :
         {std::array{face[0], face[1]}, std::array{face[1], face[2]}, std::array{face[0], face[2]}})
      ++edges[edge];
    for (const PetscInt vertex : face) ++vertices[vertex];
  }
  for (const auto &edge_and_times : edges) EXPECT_EQ(edge_and_times.second, 2);
  return std::ssize(vertices) - std::ssize(edges) + boundary_faces;
}

std::string refusal(const std::string &kind, PetscInt resolution, PetscInt refine) {
  try {
    generate_mesh(kind, resolution, refine);
  } catch (const InputError &error) {
    return error.what();
  }
  return "";
}

TEST(GenerateMesh, DefaultsHaveTwoToFiveThousandTetrahedra) {
  for (const std::string &kind : kinds) {
    const PetscInt tetrahedra = generate_mesh(kind, 0, 0).size();
    EXPECT_GE(tetrahedra, 2000) << kind;
    EXPECT_LE(tetrahedra, 5000) << kind;
    EXPECT_EQ(generate_mesh(kind, 0, 1).size(), 8 * tetrahedra) << kind;
  }
}

TEST(GenerateMesh, CoarsestBoxIsSixTetrahedraAroundADiagonal) {
  const CellList mesh = generate_mesh("box", 1, 0);
  EXPECT_EQ(mesh.vertices(), 8);
  ASSERT_EQ(mesh.size(), 6);
  for (PetscInt cell = 0; cell < 6; ++cell) {
    EXPECT_EQ(mesh.cells[4 * cell], 0);
    EXPECT_EQ(mesh.cells[4 * cell + 3], 7);
  }
}

TEST(GenerateMesh, IsConformingWithAClosedBoundary) {
  for (const std::string &kind : kinds)
    for (const PetscInt resolution : {1, 2, 3, 5}) {
      CellList mesh = generate_mesh(kind, resolution, 0);
      // A sphere, or for the knot a torus.
      EXPECT_EQ(check_conformity(mesh), kind == "knot" ? 0 : 2) << kind << ' ' << resolution;
      EXPECT_EQ(drop_unused_vertices(mesh), 0) << kind << ' ' << resolution;
    }
}

TEST(GenerateMesh, TetrahedraAreWellShapedAtEveryResolution) {
  const std::map<std::string, double> least_quality = {
      {"box", 0.75}, {"cylinder", 0.65}, {"knot", 0.12}, {"ball", 0.6}};
  for (const std::string &kind : kinds)
    for (const PetscInt resolution : {1, 2, 3, 4, 7, 12})
      EXPECT_GT(measure(generate_mesh(kind, resolution, 0)).least_quality, least_quality.at(kind))
          << kind << ' ' << resolution;
}

TEST(GenerateMesh, VolumeConvergesWithTheSquareOfTheResolution) {
  EXPECT_NEAR(measure(generate_mesh("box", 0, 0)).volume, 1, 1e-13);
  for (const std::string kind : {"cylinder", "knot", "ball"}) {
    const double exact = exact_volume(kind);
    const auto error = [&](PetscInt refine) {
      return 1 - measure(generate_mesh(kind, 0, refine)).volume / exact;
    };
    EXPECT_LT(std::abs(error(0)), 0.1) << kind;
    EXPECT_NEAR(error(0) / error(1), 4, 0.3) << kind;
    EXPECT_LT(std::abs(error(2)), 0.01) << kind;
  }
}

TEST(GenerateMesh, HasTheDocumentedExtent) {
  const auto extent = [](const CellList &mesh, std::size_t component) {
    std::array<double, 2> range{1e9, -1e9};
    for (std::size_t entry = component; entry < mesh.coordinates.size(); entry += 3) {
      range[0] = std::min(range[0], mesh.coordinates[entry]);
      range[1] = std::max(range[1], mesh.coordinates[entry]);
    }
    return range;
  };
  EXPECT_EQ(extent(generate_mesh("box", 3, 0), 1), (std::array<double, 2>{0, 1}));
  EXPECT_EQ(extent(generate_mesh("cylinder", 3, 0), 2), (std::array<double, 2>{0, 2}));
  EXPECT_NEAR(extent(generate_mesh("cylinder", 2, 0), 0)[1], 0.5, 1e-15);
  EXPECT_NEAR(extent(generate_mesh("ball", 2, 0), 2)[0], -0.5, 1e-15);
  EXPECT_NEAR(extent(generate_mesh("knot", 0, 0), 0)[1], 3.4, 1e-12);
}

TEST(GenerateMesh, RefusesWhatItCannotMake) {
  EXPECT_EQ(refusal("torus", 0, 0),
            "no mesh of kind 'torus' can be generated; choose one of box, cylinder, knot, ball, "
            "square");
  EXPECT_NE(refusal("box", -1, 0).find("resolution -1"), std::string::npos);
  EXPECT_NE(refusal("box", 0, -2).find("refinements -2"), std::string::npos);
  for (const std::string &kind : kinds) {
    EXPECT_NE(refusal(kind, 1000000, 0).find("2^31"), std::string::npos) << kind;
    EXPECT_NE(refusal(kind, 1, 31).find("2^31"), std::string::npos) << kind;
    EXPECT_NE(refusal(kind, 1, std::numeric_limits<PetscInt>::max()).find("2^31"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace trefoil
