// The forces of tractions and gravity on every element: their sum, their moment and their work in
// closed form. Needs petsc_main.cpp.

#include "scene/loads.hpp"

#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "mesh/generate.hpp"
#include "mesh/mesh.hpp"
#include "mesh/quadratic.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/dead_load_term.hpp"

namespace trefoil {
namespace {

using Vector = std::array<double, 3>;

/// The unit square or cube, straight, of elements of one kind.
struct Element {
  const char *name, *mesh;
  int dimension, order;
};

class LoadsTest : public testing::TestWithParam<Element> {
 protected:
  void SetUp() override {
    CellList whole = generate_mesh(GetParam().mesh, 4, 0);
    if (GetParam().order == 2) promote_to_quadratic(whole);
    ASSERT_EQ(distribute_mesh(PETSC_COMM_WORLD, whole, "metis", 0, &mesh_), PETSC_SUCCESS);
    ASSERT_EQ(mesh_.element_name(), GetParam().name);
    density_.assign(static_cast<std::size_t>(mesh_.local_cells()), 1);
  }

  void evaluate(const LoadsOptions &options, double time = 1) {
    Loads loads;
    ASSERT_EQ(loads.choose(mesh_, options, 1e-9, density_), PETSC_SUCCESS);
    ASSERT_EQ(loads.forces(time, &forces_), PETSC_SUCCESS);
  }
  /// Tractions on the whole side x = 1; two values in the plane, three in space.
  void pull(const std::string &two, const std::string &third, double time = 1) {
    evaluate({"", {{"side", "x == xmax", "", in_dimension(two, third)}}}, time);
  }
  [[nodiscard]] static std::string in_dimension(const std::string &two, const std::string &third) {
    return GetParam().dimension == 2 ? two : two + ", " + third;
  }

  /// sum_a f_a . u(x_a) over all ranks.
  [[nodiscard]] double work(const std::function<Vector(const double *)> &u) const {
    double sum = 0;
    for (std::size_t v = 0; v < mesh_.owned.size(); ++v) {
      const Vector at = u(&mesh_.coordinates[3 * v]);
      for (std::size_t i = 0; i < 3; ++i) sum += forces_[3 * v + i] * at[i];
    }
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return sum;
  }
  void expect_force(const Vector &expected) const {
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(work([i](const double *) {
                    Vector axis{};
                    axis[i] = 1;
                    return axis;
                  }),
                  expected[i], 1e-13)
          << i;
  }
  /// About the origin: the work of rotations.
  void expect_moment(const Vector &expected) const {
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(work([i](const double *p) {
                    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
                    Vector turned{};
                    turned[j] = -p[k];
                    turned[k] = p[j];
                    return turned;
                  }),
                  expected[i], 1e-13)
          << i;
  }
  [[nodiscard]] static bool in_space() { return GetParam().dimension == 3; }
  [[nodiscard]] static bool quadratic() { return GetParam().order == 2; }

  Mesh mesh_;
  std::vector<double> density_, forces_;
};

TEST_P(LoadsTest, ConstantTraction) {
  pull("2, -3", "5");
  // The side's middle is at (1, 1/2, 1/2), in the plane at (1, 1/2, 0).
  const Vector t{2, -3, in_space() ? 5. : 0.}, c{1, 0.5, in_space() ? 0.5 : 0};
  expect_force(t);
  expect_moment({c[1] * t[2] - c[2] * t[1], c[2] * t[0] - c[0] * t[2], c[0] * t[1] - c[1] * t[0]});
}

/// A traction of degree one: elements of order two integrate its moment, of degree two, exactly.
TEST_P(LoadsTest, LinearTractionThatGrowsInTime) {
  pull("t*(1 + y), 4*t*y", "2*t*z", 0.5);
  expect_force({0.75, 1, in_space() ? 0.5 : 0});
  if (!quadratic()) return;
  // m_x = int y t_z - z t_y, m_y = int z t_x - t_z, m_z = int t_y - y t_x
  const double m_z = 1 - 0.5 * (0.5 + 1. / 3);
  expect_moment(in_space() ? Vector{0.25 - 0.5, 0.375 - 0.5, m_z} : Vector{0, 0, m_z});
}

TEST_P(LoadsTest, TractionWorksOnWhatTheElementsRepresent) {
  pull("2, -3", "5");
  const auto field = [](const double *p) {
    return quadratic() ? Vector{p[1] * p[1], p[0] * p[1], p[1] * p[2]}
                       : Vector{p[1], 2 * p[0], p[2] - p[1]};
  };
  const double third = quadratic() ? 0.25 : 0;  // the integral of u_z in space
  EXPECT_NEAR(work(field),
              quadratic() ? 2. / 3 - 1.5 + (in_space() ? 5 * third : 0) : 1 - 6 + 5 * third, 1e-13);
}

TEST_P(LoadsTest, GravityOfABodyOfTwoDensities) {
  for (std::size_t c = 0; c < density_.size(); ++c)
    density_[c] = centroid_of_cell(mesh_, c)[0] < 0.5 ? 1 : 3;
  evaluate({in_dimension("1, -2", "4"), {}});
  // The mass is 2, its centre at x = (1/2 1/4 + 3/2 3/4) / 2 = 5/8.
  const Vector f{2, -4, in_space() ? 8. : 0.}, c{0.625, 0.5, in_space() ? 0.5 : 0};
  expect_force(f);
  expect_moment({c[1] * f[2] - c[2] * f[1], c[2] * f[0] - c[0] * f[2], c[0] * f[1] - c[1] * f[0]});
}

TEST_P(LoadsTest, GravityWorksOnWhatTheElementsRepresent) {
  evaluate({in_dimension("1, -2", "4"), {}});
  const auto field = [](const double *p) {
    return quadratic() ? Vector{p[1] * p[1], p[0] * p[1], p[2] * p[2]}
                       : Vector{p[1], 2 * p[0], p[2]};
  };
  const double plane = quadratic() ? 1. / 3 - 0.5 : 0.5 - 2, space = quadratic() ? 4. / 3 : 2.;
  EXPECT_NEAR(work(field), plane + (in_space() ? space : 0), 1e-13);
}

/// A field that grows, as a centrifuge's does: its sum at every order, its moment at order two.
TEST_P(LoadsTest, GravityThatDependsOnPlaceAndTime) {
  evaluate({in_dimension("6*t*x, 2*y", "0"), {}}, 0.5);
  expect_force({1.5, 1, 0});
  if (!quadratic()) return;
  // m_z = int x 2 y - y 3 x = -1/4, and in space m_x = -int z 2 y, m_y = int z 3 x
  expect_moment(in_space() ? Vector{-0.5, 0.75, -0.25} : Vector{0, 0, -0.25});
}

TEST_P(LoadsTest, TheFacetsOfALoadMayDependOnTime) {
  const std::string traction = in_dimension("2, -3", "5");
  for (const double time : {0., 0.5}) {  // the left side, and the right one
    evaluate({"", {{"side", "x == 2*t", "", traction}}}, time);
    expect_force({2, -3, in_space() ? 5. : 0.});
    EXPECT_NEAR(work([](const double *p) { return Vector{p[0], 0, 0}; }), 4 * time, 1e-13);
  }
}

TEST_P(LoadsTest, LoadsAddUp) {
  const std::string pull = in_dimension("2, -3", "5"), push = in_dimension("-1, 1", "0");
  evaluate({in_dimension("7, 0", "0"),
            {{"right", "x == xmax", "", pull},
             {"left", "x == xmin", "", push},
             {"top", "y == ymax", "", pull}}});
  expect_force({10, -5, in_space() ? 10. : 0.});
}

/// The nodes of a quadratic side of constant traction: 1/6, 2/3, 1/6 of an edge's force, and of a
/// triangle's none at the corners and a third at each midpoint.
TEST_P(LoadsTest, QuadraticSidesPullAtTheirMidpoints) {
  if (!quadratic()) GTEST_SKIP() << "has no midpoints";
  pull("1, 0", "0");
  const auto is_corner = [](const double *p) {
    return std::remainder(p[1], 0.25) == 0 && std::remainder(p[2], 0.25) == 0;
  };
  const double corners = work([&](const double *p) {
    return Vector{is_corner(p) ? 1. : 0., 0, 0};
  });
  EXPECT_NEAR(corners, in_space() ? 0 : 1. / 3, 1e-13);
}

TEST(DeadLoadTermTest, TheScaleIsTheWorkOfEachVertexWhateverItsSign) {
  const DeadLoadTerm term(std::vector<double>{1, 0, 2, 0, -2, 0});
  const double u[6] = {3, 5, 1, 7, 4, 9};
  EnergySums sums;
  ASSERT_EQ(term.add_energy(u, &sums), PETSC_SUCCESS);
  EXPECT_EQ(sums.energy, -(3 + 2) + 8);
  EXPECT_EQ(sums.scale, 5 + 8);
  double gradient[6] = {10, 10, 10, 10, 10, 10};
  ASSERT_EQ(term.add_gradient(u, gradient), PETSC_SUCCESS);
  const double expected[6] = {9, 10, 8, 10, 12, 10};
  for (int k = 0; k < 6; ++k) EXPECT_EQ(gradient[k], expected[k]) << k;
}

INSTANTIATE_TEST_SUITE_P(Elements, LoadsTest,
                         testing::Values(Element{"tri3", "square", 2, 1},
                                         Element{"tri6", "square", 2, 2},
                                         Element{"tet4", "box", 3, 1},
                                         Element{"tet10", "box", 3, 2}),
                         [](const auto &each) { return std::string(each.param.name); });

}  // namespace
}  // namespace trefoil
