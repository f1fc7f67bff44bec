// Each energy at states whose value can be worked out by hand.

#include <gtest/gtest.h>

#include "material_cases.hpp"

namespace trefoil::test {
namespace {

// Numbers by hand: E = 5/2 and nu = 1/4 give Lame's lambda = mu = 1, so the physical energy has
// lambda = 2, alpha = 3/2 and psi(I) = 1/4, the raw one lambda = 1, alpha = 2 and psi(I) = 1/2.
constexpr ElasticConstants unit_constants{2.5, 0.25};

TEST(StableNeoHookeanTest, UniformStretchByHand) {
  const AnyMaterial physical{StableNeoHookean(unit_constants, Lame::physical)},
      raw{StableNeoHookean(unit_constants, Lame::raw)};
  const Matrix F = diagonal(2, 2, 2);
  EXPECT_DOUBLE_EQ(physical.energy_density(F), 4.5 + 6.5 * 6.5 - 0.25);
  EXPECT_DOUBLE_EQ(raw.energy_density(F), 4.5 + 0.5 * 6 * 6 - 0.5);
  EXPECT_DOUBLE_EQ(physical.stress(F)(2, 2), 2 + 2 * 6.5 * 4);
  EXPECT_DOUBLE_EQ(raw.stress(F)(0, 0), 2 + 6.0 * 4);
  EXPECT_DOUBLE_EQ(raw.energy_density(diagonal(1, 1, -1)), 0.5 * 9 - 0.5);  // inside out
}

TEST(StableNeoHookeanTest, SimpleShearByHand) {
  const AnyMaterial physical{StableNeoHookean(unit_constants, Lame::physical)};
  Matrix F = diagonal(1, 1, 1);
  F(0, 1) = 0.6;
  EXPECT_DOUBLE_EQ(physical.energy_density(F), 0.5 * 0.36);
  const Matrix P = physical.stress(F);  // F - cof F
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(P(i, j), i + j == 1 ? 0.6 : 0.0, 1e-15);
}

TEST(StableNeoHookeanTest, RestEnergyIsTheOffset) {
  for (const Case &each : all_cases())
    for (const Lame lame : {Lame::physical, Lame::raw}) {
      if (lame == Lame::raw && each.constants.poisson <= 0) continue;
      const StableNeoHookean material(each.constants, lame);
      const double offset = material.mu() * material.mu() / (2 * material.lambda());
      EXPECT_NEAR(material.rest_energy_density() / offset, 1, 1e-14);
      EXPECT_EQ(AnyMaterial(material).energy_density(diagonal(1, 1, 1)), 0);
    }
}

}  // namespace
}  // namespace trefoil::test
