// Every material against finite differences, closed forms and the symmetries that it owes. A
// further material joins by one line in `materials`.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "material/stable_neo_hookean.hpp"
#include "matrix3_support.hpp"

namespace trefoil::test {
namespace {

using Lame = StableNeoHookean::Lame;

struct Candidate {
  const char *name;
  std::function<AnyMaterial(const ElasticConstants &)> make;
  std::function<double(const ElasticConstants &)> small_strain_lambda;
  double least_poisson;          ///< what the material takes, exclusive
  double least_singular = -1e9;  ///< of F, negative if inverted: where psi is finite and smooth
};

// At rest the raw energy has lambda (1 - alpha) = -mu in front of d cof/dF, whose entry (ij, kl) is
// delta_ij delta_kl - delta_il delta_jk: that takes mu from lambda, and gives the shear its
// symmetry.
const std::vector<Candidate> materials{
    {"stable_neo_hookean",
     [](const ElasticConstants &c) { return AnyMaterial(StableNeoHookean(c, Lame::physical)); },
     [](const ElasticConstants &c) { return c.lambda(); }, -1},
    {"stable_neo_hookean_raw",
     [](const ElasticConstants &c) { return AnyMaterial(StableNeoHookean(c, Lame::raw)); },
     [](const ElasticConstants &c) { return c.lambda() - c.mu(); }, 0},
};

struct Case {
  Candidate candidate;
  ElasticConstants constants;

  friend std::ostream &operator<<(std::ostream &stream, const Case &each) {
    return stream << each.candidate.name << " nu " << each.constants.poisson;
  }
};

std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const Candidate &candidate : materials)
    for (const double poisson : {-0.5, 0.0, 0.05, 0.2, 0.3, 0.45, 0.495, 0.4999})
      if (poisson > candidate.least_poisson) cases.push_back({candidate, {3.0, poisson}});
  return cases;
}

std::string case_name(const testing::TestParamInfo<Case> &info) {
  const int poisson = static_cast<int>(std::lround(1e4 * info.param.constants.poisson));
  return std::string(info.param.candidate.name) + (poisson < 0 ? "_nu_minus_" : "_nu_") +
         std::to_string(std::abs(poisson));
}

struct State {
  std::string name;
  Matrix F;
};

/// Deformations of every kind, by their singular values; the last one is negative where inverted.
std::vector<State> states(double least_singular) {
  struct Kind {
    const char *name;
    double a, b, c;
  };
  const Kind kinds[] = {{"rest", 1, 1, 1},
                        {"uniform", 2, 2, 2},
                        {"two equal", 0.7, 0.7, 1.6},
                        {"generic", 1.4, 0.9, 0.6},
                        {"flattened", 2, 1, 0.02},
                        {"nearly singular", 1.2, 0.8, 1e-8},
                        {"singular", 1.2, 0.8, 0},
                        {"line", 1.5, 0, 0},
                        {"point", 0, 0, 0},
                        {"inverted", 1.3, 0.8, -.5},
                        {"reflected", 1, 1, -1},
                        {"inside out", -1, -1, -1},
                        {"thread", 1e3, 1, 1},
                        {"sheet", 1e3, 1e3, 1e-8},
                        {"huge", 1e4, 1e4, 1e4},
                        {"huge inverted", 300, 2, -40}};
  Random random(1);
  std::vector<State> list;
  for (const Kind &kind : kinds) {
    if (kind.c <= least_singular) continue;
    const Matrix D = diagonal(kind.a, kind.b, kind.c);
    list.push_back({kind.name, D});
    list.push_back({std::string(kind.name) + ", rotated", random.rotation() * D});
    list.push_back(
        {std::string(kind.name) + ", turned", random.rotation() * D * random.rotation()});
  }
  for (int i = 0; i < 20; ++i) {
    const Matrix F = random.matrix(1.5);
    if (determinant(F) > 0.1 || least_singular < 0)
      list.push_back({"random " + std::to_string(i), F});
  }
  return list;
}

/// A step that is small for F, whatever its size.
double step_at(const Matrix &F) {
  return 1e-3 * std::max(1.0, std::cbrt(std::abs(determinant(F))));
}

class MaterialTest : public testing::TestWithParam<Case> {
 protected:
  AnyMaterial material_ = GetParam().candidate.make(GetParam().constants);
  std::vector<State> states_ = states(GetParam().candidate.least_singular);
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
  for (const auto &[name, F] : states_) {
    const Matrix P = material_.stress(F);
    const double scale = norm(P) + norm(material_.tangent(F));
    for (int direction = 0; direction < 4; ++direction) {
      const Matrix D = random_.matrix();
      const double slope = derivative(
          step_at(F), [&](double s) { return material_.energy_density(along(F, s, D)); });
      EXPECT_NEAR(slope, dot(P, D), 1e-8 * scale) << name;
    }
  }
}

TEST_P(MaterialTest, TangentIsTheDerivativeOfTheStress) {
  for (const auto &[name, F] : states_) {
    const Tangent<double> A = material_.tangent(F);
    for (std::size_t q = 0; q < 9; ++q) {
      Matrix D;
      D.entries[q] = 1;
      for (std::size_t p = 0; p < 9; ++p) {
        const double slope = derivative(
            step_at(F), [&](double s) { return material_.stress(along(F, s, D)).entries[p]; });
        EXPECT_NEAR(slope, A[9 * p + q], 1e-8 * norm(A)) << name << ' ' << p << ' ' << q;
      }
    }
  }
}

TEST_P(MaterialTest, TangentIsSymmetric) {
  for (const auto &[name, F] : states_) {
    const Tangent<double> A = material_.tangent(F);
    for (std::size_t p = 0; p < 9; ++p)
      for (std::size_t q = 0; q < p; ++q)
        EXPECT_NEAR(A[9 * p + q], A[9 * q + p], 1e-15 * norm(A)) << name << ' ' << p << ' ' << q;
  }
}

TEST_P(MaterialTest, IsObjectiveAndIsotropic) {
  for (const auto &[name, F] : states_) {
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
  const double lambda = GetParam().candidate.small_strain_lambda(GetParam().constants);
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
  const double lambda = GetParam().candidate.small_strain_lambda(GetParam().constants);
  const double mu = GetParam().constants.mu();
  if (lambda + 2 * mu / 3 <= 0) GTEST_SKIP() << "the bulk modulus is negative: unstable at rest";
  const double young = mu * (3 * lambda + 2 * mu) / (lambda + mu);
  const double poisson = lambda / (2 * (lambda + mu));
  if (GetParam().candidate.least_poisson < 0) {
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
    for (const auto &[name, F] : states_) {
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

// Numbers by hand: E = 5/2 and nu = 1/4 give Lame's lambda = mu = 1, so the physical energy has
// lambda = 2 and alpha = 3/2, the raw one lambda = 1 and alpha = 2.
constexpr ElasticConstants unit_constants{2.5, 0.25};

TEST(StableNeoHookeanTest, UniformStretchByHand) {
  const StableNeoHookean physical(unit_constants, Lame::physical), raw(unit_constants, Lame::raw);
  const Matrix F = diagonal(2, 2, 2);
  EXPECT_DOUBLE_EQ(physical.energy_density(F), 4.5 + 6.5 * 6.5);
  EXPECT_DOUBLE_EQ(raw.energy_density(F), 4.5 + 0.5 * 6 * 6);
  EXPECT_DOUBLE_EQ(physical.stress(F)(2, 2), 2 + 2 * 6.5 * 4);
  EXPECT_DOUBLE_EQ(raw.stress(F)(0, 0), 2 + 6.0 * 4);
  EXPECT_DOUBLE_EQ(raw.energy_density(diagonal(1, 1, -1)), 0.5 * 9);  // inside out
}

TEST(StableNeoHookeanTest, SimpleShearByHand) {
  const StableNeoHookean physical(unit_constants, Lame::physical);
  Matrix F = diagonal(1, 1, 1);
  F(0, 1) = 0.6;
  EXPECT_DOUBLE_EQ(physical.energy_density(F), 0.5 * 0.36 + 0.25);
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
      EXPECT_NEAR(material.energy_density(diagonal(1, 1, 1)) / offset, 1, 1e-10);
    }
}

}  // namespace
}  // namespace trefoil::test
