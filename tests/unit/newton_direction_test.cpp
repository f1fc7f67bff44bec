// Newton's direction from the factors of a filtered Jacobian, on the chain. Runs on any number of
// ranks; needs petsc_main.cpp.

#include "plugin_fixture.hpp"

namespace trefoil::test {
namespace {

/// What a solve came to.
struct Outcome {
  bool converged = false;
  int iterations = 0, newton_steps = 0;
  double energy = 0;
};

/// To a minimum where nearly half of the bars are concave.
Outcome solve(const std::string &most_steps, const std::string &filter = "clamp") {
  Host host;
  Outcome outcome;
  host.chain.anchor = 1;
  host.chain.place = 0.5;
  host.option("snes_trefoil_filter", filter);
  host.option("snes_trefoil_energy_tolerance", "1e-14");
  if (!most_steps.empty()) host.option("snes_trefoil_newton_steps", most_steps);
  EXPECT_EQ(host.set_up(), PETSC_SUCCESS);
  EXPECT_EQ(host.solve(stretched(host.chain, 0.4, 0.7)), PETSC_SUCCESS);
  expect_descent(host);
  for (const auto &entry : host.history()) {
    outcome.newton_steps += entry.at("newton_steps").get<int>();
    if (!most_steps.empty()) {
      EXPECT_LE(entry.at("newton_steps"), std::stoi(most_steps));
    }
    if (entry.at("weight") > 0.5) {
      EXPECT_EQ(entry.at("newton_steps"), 0);
    }
  }
  const auto &result = host.record.at("result");
  outcome.converged = host.reason > 0;
  outcome.iterations = result.at("iterations");
  outcome.energy = result.at("energy");
  EXPECT_EQ(result.at("linear_solves"), outcome.iterations + outcome.newton_steps);
  return outcome;
}

TEST(NewtonDirectionTest, ConvergesAsNewtonsMethodWithTheFactorsOfAFilteredHessian) {
  const Outcome filtered = solve("0"), turned = solve("24");
  EXPECT_EQ(filtered.newton_steps, 0);
  EXPECT_GT(turned.newton_steps, 0);
  EXPECT_LE(2 * turned.iterations, filtered.iterations);
  EXPECT_TRUE(turned.converged);
  EXPECT_LE(turned.energy, filtered.energy);
}

TEST(NewtonDirectionTest, OtherRulesThanNewtonFirstTakeNoneUnlessTheyAreTold) {
  EXPECT_EQ(solve("").newton_steps, 0);
}

TEST(NewtonDirectionTest, NoneWhereTheFilterIsTrustedAndNotTheModel) {
  EXPECT_EQ(solve("24", "absolute").newton_steps, 0);
}

/// Where the first curvature is negative already the filtered direction is what is left.
TEST(NewtonDirectionTest, NegativeCurvatureLeavesADirectionThatDescends) {
  for (const char *filter : {"clamp", "newton_first", "adaptive"}) {
    Host host;
    host.chain.anchor = 0.01;
    host.option("snes_trefoil_filter", filter);
    host.option("snes_trefoil_newton_steps", "24");
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
    EXPECT_GT(host.reason, 0) << filter;
    expect_descent(host);
  }
}

}  // namespace
}  // namespace trefoil::test
