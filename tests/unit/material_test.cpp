// Every material against finite differences, closed forms and the symmetries that it owes. A
// further material joins by one line in material_cases.hpp.

#include <gtest/gtest.h>

#include <limits>

#include "material_cases.hpp"

namespace trefoil::test {
namespace {

class MaterialTest : public testing::TestWithParam<Case> {
 protected:
  AnyMaterial material_ = GetParam().material();
  std::vector<State> states_ = GetParam().states();
  Random random_{2};

  /// What the terms of psi are large as; psi itself may be their small difference.
  [[nodiscard]] double energy_scale(const Matrix &F) const {
    return norm(material_.tangent(F)) * (1 + dot(F, F)) + std::abs(material_.energy_density(F));
  }
  [[nodiscard]] double stress_scale(const Matrix &F) const {
    return norm(material_.tangent(F)) * (1 + norm(F));
  }
};

TEST_P(MaterialTest, StressIsTheDerivativeOfTheEnergy) {
  for (const auto &[name, F, step] : states_) {
    const Matrix P = material_.stress(F);
    // In some points all derivatives vanish, which rounding does not.
    const double at_rest = norm(material_.tangent(diagonal(1, 1, 1)));
    const double scale = norm(P) + norm(material_.tangent(F)) + 1e-3 * at_rest;
    for (int direction = 0; direction < 4; ++direction) {
      const Matrix D = random_.matrix();
      const double slope =
          derivative(step, [&](double s) { return material_.energy_density(along(F, s, D)); });
      EXPECT_NEAR(slope, dot(P, D), 1e-8 * scale) << name;
    }
  }
}

TEST_P(MaterialTest, TangentIsTheDerivativeOfTheStress) {
  for (const auto &[name, F, step] : states_) {
    const Tangent<double> A = material_.tangent(F);
    const double scale = norm(A) + 1e-3 * norm(material_.tangent(diagonal(1, 1, 1)));
    for (std::size_t q = 0; q < 9; ++q) {
      Matrix D;
      D.entries[q] = 1;
      for (std::size_t p = 0; p < 9; ++p) {
        const double slope =
            derivative(step, [&](double s) { return material_.stress(along(F, s, D)).entries[p]; });
        EXPECT_NEAR(slope, A[9 * p + q], 1e-8 * scale) << name << ' ' << p << ' ' << q;
      }
    }
  }
}

TEST_P(MaterialTest, TangentIsSymmetric) {
  for (const auto &[name, F, step] : states_) {
    const Tangent<double> A = material_.tangent(F);
    for (std::size_t p = 0; p < 9; ++p)
      for (std::size_t q = 0; q < p; ++q)
        EXPECT_NEAR(A[9 * p + q], A[9 * q + p], 1e-15 * norm(A)) << name << ' ' << p << ' ' << q;
  }
}

TEST_P(MaterialTest, IsObjectiveAndIsotropic) {
  for (const auto &[name, F, step] : states_) {
    const Matrix Q = random_.rotation();
    const double energy = material_.energy_density(F), tolerance = 1e-13 * energy_scale(F);
    EXPECT_NEAR(material_.energy_density(Q * F), energy, tolerance) << name;
    EXPECT_NEAR(material_.energy_density(F * Q), energy, tolerance) << name;
    const Matrix turned = along(material_.stress(Q * F), -1, Q * material_.stress(F));
    EXPECT_LE(norm(turned), 1e-13 * stress_scale(F)) << name;
    const Matrix isotropic = along(material_.stress(F * Q), -1, material_.stress(F) * Q);
    EXPECT_LE(norm(isotropic), 1e-13 * stress_scale(F)) << name;
  }
}

TEST_P(MaterialTest, IsFreeOfStressAtRest) {
  for (const Matrix &Q : {diagonal(1, 1, 1), random_.rotation(), random_.rotation()})
    EXPECT_LE(norm(material_.stress(Q)), 1e-14 * norm(material_.tangent(Q)));
}

// Hooke's law, dP_ij/dF_kl = lambda d_ij d_kl + mu (d_ik d_jl + d_il d_jk).
TEST_P(MaterialTest, TangentAtRestIsHookesLaw) {
  const double lambda = GetParam().small_strain_lambda();
  const double mu = GetParam().constants.mu();
  const Tangent<double> A = material_.tangent(diagonal(1, 1, 1));
  const auto delta = [](int i, int j) { return i == j ? 1.0 : 0.0; };
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
          const double hooke = lambda * delta(i, j) * delta(k, l) +
                               mu * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k));
          EXPECT_NEAR(A[static_cast<std::size_t>(9 * (3 * i + j) + 3 * k + l)], hooke,
                      1e-14 * norm(A));
        }
}

/// Pulls a bar to the strain `strain` and lets its sides go where they are free of stress.
/// @return its axial stress and the strain of its sides
std::pair<double, double> pull(const AnyMaterial &material, double strain) {
  double side = 0;
  for (int iteration = 0; iteration < 30; ++iteration) {
    const Matrix F = diagonal(1 + strain, 1 + side, 1 + side);
    const Tangent<double> A = material.tangent(F);
    side -= material.stress(F)(1, 1) / (A[9 * 4 + 4] + A[9 * 4 + 8]);
  }
  return {material.stress(diagonal(1 + strain, 1 + side, 1 + side))(0, 0), side};
}

TEST_P(MaterialTest, ABarObeysYoungAndPoissonAtSmallStrain) {
  const double lambda = GetParam().small_strain_lambda();
  const double mu = GetParam().constants.mu();
  if (lambda + 2 * mu / 3 <= 0) GTEST_SKIP() << "the bulk modulus is negative: unstable at rest";
  const double young = mu * (3 * lambda + 2 * mu) / (lambda + mu);
  const double poisson = lambda / (2 * (lambda + mu));
  if (GetParam().candidate.obeys_young_and_poisson) {
    EXPECT_NEAR(young, GetParam().constants.young, 1e-9);  // no detour: E and nu as given
    EXPECT_NEAR(poisson, GetParam().constants.poisson, 1e-12);
  }
  // The mean of pulling and pushing has no term of second order in the strain.
  constexpr double strain = 1e-4;
  const auto [tension, thinner] = pull(material_, strain);
  const auto [pressure, thicker] = pull(material_, -strain);
  EXPECT_NEAR((tension - pressure) / (2 * strain), young, 1e-6 * young);
  EXPECT_NEAR((thicker - thinner) / (2 * strain), poisson, 1e-6);
}

TEST_P(MaterialTest, KnowsNoUnits) {
  const ElasticConstants constants = GetParam().constants;
  // A power of two goes through every product without rounding.
  const double two_to_40 = std::ldexp(1, 40);
  for (const double factor : {two_to_40, 1 / two_to_40, 1e12, 1e-12}) {
    const bool exact = factor == two_to_40 || factor == 1 / two_to_40;
    const AnyMaterial scaled =
        GetParam().candidate.make({factor * constants.young, constants.poisson});
    for (const auto &[name, F, step] : states_) {
      const double tolerance = exact ? 0 : 1e-14;
      EXPECT_NEAR(scaled.energy_density(F) / factor, material_.energy_density(F),
                  tolerance * energy_scale(F))
          << name;
      const Matrix P = scaled.stress(F);
      for (std::size_t p = 0; p < 9; ++p)
        EXPECT_NEAR(P.entries[p] / factor, material_.stress(F).entries[p],
                    tolerance * stress_scale(F))
            << name;
    }
  }
}

TEST_P(MaterialTest, NotANumberStaysOne) {
  Matrix F = diagonal(1, 1, 1);
  F(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(material_.energy_density(F)));
  EXPECT_TRUE(std::isnan(norm(material_.stress(F))));
}

INSTANTIATE_TEST_SUITE_P(All, MaterialTest, testing::ValuesIn(all_cases()), case_name);

TEST(BarrierTest, EnergiesAreInfiniteWhereTheVolumeIsNotPositive) {
  for (const Case &each : all_cases()) {
    if (each.candidate.room != to_inversion) continue;
    for (const Matrix &F : {diagonal(1, 1, -1), diagonal(1.3, 0.8, -0.5), diagonal(-1, -1, -1),
                            diagonal(1.2, 0.8, 0), diagonal(1.5, 0, 0), diagonal(0, 0, 0)})
      EXPECT_EQ(each.material().energy_density(F), std::numeric_limits<double>::infinity()) << each;
  }
}

// Where two stretches of an inverted F nearly cancel, the rotation turns with the twist of their
// directions by one over their sum, but by no more than 1e6.

struct Cancelling {
  double longest, other, sum;  ///< stretches longest, other and sum - other

  [[nodiscard]] double trace_of_strain() const { return longest + sum - 3; }
  /// The sum over the three twists of 1 / (sum of its stretches), as it counts.
  [[nodiscard]] double turning() const {
    const double last = sum - other;
    return 1 / std::max(longest + other, 1e-6) + 1 / std::max(longest + last, 1e-6) +
           1 / std::max(sum, 1e-6);
  }
};

const std::vector<Cancelling> cancelling{{1.3, 0.8, 0},    {1.3, 0.8, 1e-12},  {1.3, 0.8, 1e-9},
                                         {1.3, 0.8, 9e-7}, {1.3, 0.8, 1.1e-6}, {1.3, 0.8, 1e-4},
                                         {2, 0, 0},        {2, 3e-7, 5e-7},    {1, 1, 0},
                                         {0.5, 0.5, 3e-7}, {0, 0, 0},          {4e-7, 3e-7, 2e-7}};

/// A tangent by its numbers: finite, symmetric, and of the trace that it should have.
void expect_tangent(const Tangent<double> &A, double trace, const Cancelling &state) {
  double sum = 0;
  for (std::size_t p = 0; p < 9; ++p) {
    sum += A[10 * p];
    for (std::size_t q = 0; q < p; ++q) {
      ASSERT_TRUE(std::isfinite(A[9 * p + q]));
      EXPECT_NEAR(A[9 * p + q], A[9 * q + p], 1e-15 * norm(A));
    }
  }
  EXPECT_NEAR(sum / trace, 1, 1e-9) << state.longest << ' ' << state.other << ' ' << state.sum;
}

/// The twist of the second and the third direction, of length one, is an eigenvector.
void expect_twist(const Tangent<double> &A, double eigenvalue, const Matrix &U, const Matrix &V) {
  Matrix twist;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      twist(i, j) = std::sqrt(0.5) * (U(i, 1) * V(j, 2) - U(i, 2) * V(j, 1));
  EXPECT_LE(norm(along(test::apply(A, twist), -eigenvalue, twist)), 1e-6 * std::abs(eigenvalue));
}

TEST(CancellingStretchesTest, TangentsGrowToWhatTheClampAllows) {
  Random random(6);
  const MaterialParameters parameters{{3, 0.4}, 0.0};  // without a volume term
  const double mu = parameters.constants.mu(), lambda = parameters.constants.lambda();
  const AnyMaterial arap{Arap(parameters)}, corotated{Corotated(parameters)};
  for (const Cancelling &state : cancelling) {
    for (int turn = 0; turn < 20; ++turn) {
      const Matrix U = random.rotation(), V = random.rotation();
      Matrix transposed;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) transposed(i, j) = V(j, i);
      const Matrix F =
          U * diagonal(state.longest, state.other, state.sum - state.other) * transposed;
      Tangent<double> A = arap.tangent(F);
      // A = 2 mu I - 2 mu dR/dF; a twist's square is 2.
      expect_tangent(A, 18 * mu - 4 * mu * state.turning(), state);
      const bool known = state.other >= 0.5 && state.other < state.longest && state.sum >= 1e-9;
      const double turning = 2 / std::max(state.sum, 1e-6);
      if (known) expect_twist(A, 2 * mu - 2 * mu * turning, U, V);
      // A = 2 mu I + lambda R (x) R + (lambda tr - 2 mu) dR/dF, and |R|^2 = 3.
      const double factor = lambda * state.trace_of_strain() - 2 * mu;
      A = corotated.tangent(F);
      expect_tangent(A, 18 * mu + 3 * lambda + 2 * factor * state.turning(), state);
      if (known) expect_twist(A, 2 * mu + factor * turning, U, V);
    }
  }
}

}  // namespace
}  // namespace trefoil::test
