// The surface of a distributed mesh: every facet once, none between ranks. Needs petsc_main.cpp.

#include "mesh/boundary.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/generate.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

double sum_over_ranks(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return value;
}

class BoundaryTest : public testing::Test {
 protected:
  PetscErrorCode distribute(const CellList &whole) {
    PetscFunctionBeginUser;
    PetscCall(distribute_mesh(PETSC_COMM_WORLD, whole, "metis", 0, &mesh_));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  [[nodiscard]] const double *position(PetscInt vertex) const {
    return &mesh_.coordinates[static_cast<std::size_t>(3 * vertex)];
  }
  [[nodiscard]] double area(const Facet &facet) const {
    const double *a = position(facet.vertices[0]), *b = position(facet.vertices[1]),
                 *c = position(facet.vertices[2]);
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      sum += std::pow((b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]), 2);
    }
    return std::sqrt(sum) / 2;
  }
  Mesh mesh_;
};

TEST_F(BoundaryTest, TheSurfaceOfACubeIsSix) {
  ASSERT_EQ(distribute(generate_mesh("box", 4, 0)), PETSC_SUCCESS);
  std::vector<Facet> facets;
  ASSERT_EQ(boundary_facets(
                mesh_, [](const Facet &) { return true; }, &facets),
            PETSC_SUCCESS);
  double total = 0;
  for (const Facet &facet : facets) {
    total += area(facet);
    bool on_a_side = false;
    for (int i = 0; i < 3; ++i)
      for (const double side : {0., 1.})
        on_a_side = on_a_side || (position(facet.vertices[0])[i] == side &&
                                  position(facet.vertices[1])[i] == side &&
                                  position(facet.vertices[2])[i] == side);
    EXPECT_TRUE(on_a_side);
  }
  EXPECT_EQ(sum_over_ranks(static_cast<double>(facets.size())), 6 * 2 * 16);
  EXPECT_NEAR(sum_over_ranks(total), 6, 1e-12);
}

TEST_F(BoundaryTest, OnlyWhatIsWanted) {
  ASSERT_EQ(distribute(generate_mesh("box", 4, 0)), PETSC_SUCCESS);
  std::vector<Facet> facets;
  const auto on_top = [&](const Facet &facet) {
    return position(facet.vertices[0])[2] == 1 && position(facet.vertices[1])[2] == 1 &&
           position(facet.vertices[2])[2] == 1;
  };
  ASSERT_EQ(boundary_facets(mesh_, on_top, &facets), PETSC_SUCCESS);
  EXPECT_EQ(sum_over_ranks(static_cast<double>(facets.size())), 32);
  ASSERT_EQ(boundary_facets(
                mesh_, [](const Facet &) { return false; }, &facets),
            PETSC_SUCCESS);
  EXPECT_TRUE(facets.empty());
}

/// A closed surface has an even number of facets at every edge and 2 vertices more than half as
/// many facets; on a knot, whose surface is a torus, just as many.
TEST_F(BoundaryTest, EulersFormula) {
  for (const auto &[kind, characteristic] : {std::pair{"ball", 2.}, std::pair{"knot", 0.}}) {
    Mesh mesh;
    ASSERT_EQ(distribute_mesh(PETSC_COMM_WORLD, generate_mesh(kind, 2, 0), "metis", 0, &mesh),
              PETSC_SUCCESS);
    std::vector<Facet> facets;
    ASSERT_EQ(boundary_facets(
                  mesh, [](const Facet &) { return true; }, &facets),
              PETSC_SUCCESS);
    std::vector<double> touched(mesh.coordinates.size(), 0);
    for (const Facet &facet : facets)
      for (const PetscInt vertex : facet) touched[static_cast<std::size_t>(3 * vertex)] = 1;
    ASSERT_EQ(sum_at_owners(mesh, &touched), PETSC_SUCCESS);
    double vertices = 0;
    for (const double count : touched) vertices += count > 0;
    // V - E + F with E = 3 F / 2
    const double euler =
        sum_over_ranks(vertices) - 0.5 * sum_over_ranks(static_cast<double>(facets.size()));
    EXPECT_EQ(euler, characteristic) << kind;
  }
}

TEST_F(BoundaryTest, OwnersAddUpAndOthersHaveNothing) {
  ASSERT_EQ(distribute(generate_mesh("box", 3, 0)), PETSC_SUCCESS);
  std::vector<double> values;
  double before = 0, after = 0;
  for (std::size_t v = 0; v < mesh_.owned.size(); ++v)
    for (int i = 0; i < 3; ++i) values.push_back(position(static_cast<PetscInt>(v))[i] + i);
  for (const double value : values) before += value;
  ASSERT_EQ(sum_at_owners(mesh_, &values), PETSC_SUCCESS);
  for (std::size_t k = 0; k < values.size(); ++k) {
    after += values[k];
    const double here = position(static_cast<PetscInt>(k / 3))[k % 3] + static_cast<double>(k % 3);
    if (!mesh_.owned[k / 3]) {
      EXPECT_EQ(values[k], 0) << k;
    } else if (here > 0) {  // a whole number of ranks has the vertex
      EXPECT_NEAR(std::remainder(values[k] / here, 1), 0, 1e-12) << k;
      EXPECT_GE(values[k] / here, 1 - 1e-12) << k;
    }
  }
  EXPECT_NEAR(sum_over_ranks(after), sum_over_ranks(before), 1e-9);
}

}  // namespace
}  // namespace trefoil
