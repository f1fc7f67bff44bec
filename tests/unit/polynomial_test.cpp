// The polynomial that the plane search makes of sampled energies.

#include "search/polynomial.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace trefoil {
namespace {

using Point = Polynomial::Point;

/// A random polynomial of total degree six, evaluated by its definition.
struct Monomials {
  int variables;
  std::vector<double> coefficients;

  Monomials(int count, int degree, unsigned seed) : variables(count) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    for (int j = 0; j <= degree; ++j)
      for (int i = 0; i <= degree; ++i)
        coefficients.push_back(i + j <= degree && (j == 0 || count == 2) ? normal(engine) : 0);
  }
  [[nodiscard]] double at(const Point &p) const {
    const auto side = static_cast<int>(std::lround(std::sqrt(coefficients.size())));
    double sum = 0;
    for (int k = 0; k < side * side; ++k)
      sum += coefficients[static_cast<std::size_t>(k)] * std::pow(p[0], k % side) *
             std::pow(p[1], static_cast<double>(k / side));
    return sum;
  }
  [[nodiscard]] std::vector<double> values(const std::vector<Point> &points) const {
    std::vector<double> values;
    for (const Point &p : points) values.push_back(at(p));
    return values;
  }
};

class PolynomialTest : public testing::TestWithParam<std::pair<int, int>> {};

TEST_P(PolynomialTest, HasAsManyNodesAsCoefficients) {
  const auto [variables, degree] = GetParam();
  const auto nodes = Polynomial::nodes(variables, degree);
  EXPECT_EQ(nodes.size(), static_cast<std::size_t>(
                              variables == 1 ? degree + 1 : (degree + 1) * (degree + 2) / 2));
  for (const Point &node : nodes)
    EXPECT_LE(std::max(std::abs(node[0]), std::abs(node[1])), 1 + 1e-15);
}

TEST_P(PolynomialTest, IsThePolynomialItWasSampledFrom) {
  const auto [variables, degree] = GetParam();
  const auto nodes = Polynomial::nodes(variables, degree);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Monomials truth(variables, degree, seed);
    const Polynomial found(variables, degree, truth.values(nodes));
    std::mt19937 engine(seed);
    std::uniform_real_distribution<double> uniform(-3, 3);
    for (int k = 0; k < 20; ++k) {
      const Point p{uniform(engine), variables == 2 ? uniform(engine) : 0};
      const double size = std::pow(4, degree);
      EXPECT_NEAR(found.at(p), truth.at(p), 1e-12 * size);
      // Derivatives, by central differences.
      Point gradient, up, down;
      std::array<double, 3> curvature;
      static_cast<void>(found.at(p, &gradient, &curvature));
      const double h = 1e-5;
      const auto moved = [&](std::size_t axis, double by) {
        Point q = p;
        q[axis] += by;
        return q;
      };
      for (std::size_t axis = 0; axis < static_cast<std::size_t>(variables); ++axis) {
        EXPECT_NEAR(gradient[axis],
                    (found.at(moved(axis, h)) - found.at(moved(axis, -h))) / (2 * h), 1e-6 * size);
        static_cast<void>(found.at(moved(axis, h), &up));
        static_cast<void>(found.at(moved(axis, -h), &down));
        EXPECT_NEAR(curvature[2 * axis], (up[axis] - down[axis]) / (2 * h), 1e-6 * size);
        EXPECT_NEAR(curvature[1], (up[1 - axis] - down[1 - axis]) / (2 * h), 1e-6 * size);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, PolynomialTest,
                         testing::Values(std::pair{1, 2}, std::pair{1, 6}, std::pair{2, 2},
                                         std::pair{2, 6}),
                         [](const auto &each) {
                           return "variables_" + std::to_string(each.param.first) + "_degree_" +
                                  std::to_string(each.param.second);
                         });

/// The polynomial of degree six through a function's values.
template <class Function>
Polynomial sampled(int variables, const Function &function) {
  std::vector<double> values;
  for (const Point &p : Polynomial::nodes(variables, 6)) values.push_back(function(p));
  return {variables, 6, values};
}

TEST(MinimumTest, OfAParabola) {
  const Polynomial line =
      sampled(1, [](const Point &p) { return 3 * std::pow(p[0] - 0.25, 2) - 7; });
  EXPECT_NEAR(line.minimum_from({1, 0}, 3)[0], 0.25, 1e-8);
  const Polynomial plane = sampled(2, [](const Point &p) {
    return std::pow(p[0] - 0.25, 2) + 100 * std::pow(p[1] + 0.5 - p[0], 2);
  });
  const Point found = plane.minimum_from({1, 0}, 3);
  EXPECT_NEAR(found[0], 0.25, 1e-7);
  EXPECT_NEAR(found[1], -0.25, 1e-7);
}

TEST(MinimumTest, OfANarrowValleyAcrossTheAxes) {
  // Steps along other directions than the valley's own would creep.
  const Polynomial valley = sampled(2, [](const Point &p) {
    return std::pow(p[0] + 2 * p[1] - 0.5, 2) + 1e6 * std::pow(2 * p[0] - p[1], 2);
  });
  const Point found = valley.minimum_from({1, 0}, 3);
  EXPECT_NEAR(found[0], 0.1, 1e-6);
  EXPECT_NEAR(found[1], 0.2, 1e-6);
}

TEST(MinimumTest, LeavesASaddleAndStaysDownhill) {
  // A double well along x: from the right slope its right minimum, (1, 0), never the hill at 0.
  const Polynomial wells = sampled(
      2, [](const Point &p) { return std::pow(p[0] * p[0] - 1, 2) + p[1] * p[1] * (1 + p[0]); });
  const Point found = wells.minimum_from({0.3, 0.4}, 3);
  EXPECT_NEAR(found[0], 1, 1e-6);
  EXPECT_NEAR(found[1], 0, 1e-6);
}

TEST(MinimumTest, StaysWithinBounds) {
  const Polynomial slope = sampled(2, [](const Point &p) { return -p[0] - 2 * p[1]; });
  const Point found = slope.minimum_from({0, 0}, 2.5);
  EXPECT_NEAR(found[0], 2.5, 1e-12);
  EXPECT_NEAR(found[1], 2.5, 1e-12);
}

TEST(MinimumTest, IsNeverAboveItsStart) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Monomials truth(2, 6, seed);
    const Polynomial polynomial(2, 6, truth.values(Polynomial::nodes(2, 6)));
    const Point start{uniform(engine), uniform(engine)};
    EXPECT_LE(polynomial.at(polynomial.minimum_from(start, 3)), polynomial.at(start));
  }
}

}  // namespace
}  // namespace trefoil
