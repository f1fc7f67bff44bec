// Materials of the registry: found by their names, and in packs, for every instruction set that
// this machine has, what they are for one deformation gradient.

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "material_cases.hpp"
#include "simd/instruction_set.hpp"
#include "trefoil/material_registry.hpp"

namespace trefoil::test {
namespace {

class MaterialPacksTest : public testing::TestWithParam<std::tuple<std::string, InstructionSet>> {
 protected:
  void SetUp() override {
    if (!processor_has(std::get<1>(GetParam()))) GTEST_SKIP() << "not on this processor";
    const auto &[name, instructions] = GetParam();
    model_ = make_material(name, {{3, 0.4}}, instructions);
    for (const Candidate &candidate : materials)
      if (candidate.name == name) plain_ = candidate.make({3, 0.4});
    ASSERT_TRUE(plain_) << "no numbers to compare with";
  }
  std::unique_ptr<MaterialModel> model_;
  std::optional<AnyMaterial> plain_;  ///< the same material for numbers
};

/// The displacement gradients of eight states, as packs have them.
struct PackedStates {
  alignas(64) double H[9 * lanes];
  explicit PackedStates(const State *states) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const Matrix gradient = less_identity(states[lane].F);
      for (std::size_t k = 0; k < 9; ++k) H[lanes * k + lane] = gradient.entries[k];
    }
  }
};

/// States of every kind, a multiple of eight.
std::vector<State> packs_of_states(Room room) {
  std::vector<State> states = all_states(room);
  while (states.size() % lanes) states.push_back(states.front());
  return states;
}

/// What the rounding of F itself does to a value whose derivative this is.
double noise_of(const Tangent<double> &A, const Matrix &F) {
  return 1e-13 * norm(A) * (1 + norm(F));
}

TEST_P(MaterialPacksTest, ArePlainMaterials) {
  const bool has_barrier = !std::isfinite(plain_->energy_density(diagonal(1, 1, -1)));
  const std::vector<State> states = packs_of_states(endless);
  for (std::size_t first = 0; first < states.size(); first += lanes) {
    const PackedStates packed(&states[first]);
    alignas(64) double psi[lanes], P[9 * lanes], A[81 * lanes];
    model_->energy_densities(packed.H, psi);
    model_->stresses(packed.H, P);
    model_->tangents(packed.H, A);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const auto &[name, gradient, step] = states[first + lane];
      const double energy = plain_->energy_density(gradient);
      if (!std::isfinite(energy)) {
        EXPECT_EQ(psi[lane], energy) << name;
        continue;
      }
      // At the barrier J = 0 even the sign of J is rounding's choice; where two stretches cancel,
      // a rotation is.
      if (has_barrier && std::abs(determinant(gradient)) < 1e-6 * std::pow(norm(gradient), 3)) {
        continue;
      }
      const auto stretch = signed_svd(gradient).stretch;
      const bool is_defined = stretch[1] + stretch[2] > 1e-7;
      const Matrix stress = plain_->stress(gradient);
      const Tangent<double> tangent = plain_->tangent(gradient);
      const double noise = noise_of(tangent, gradient);
      EXPECT_NEAR(psi[lane], energy, noise * (1 + norm(gradient)) + 1e-13 * std::abs(energy))
          << name;
      for (std::size_t p = 0; is_defined && p < 9; ++p) {
        EXPECT_NEAR(P[lanes * p + lane], stress.entries[p], noise) << name;
      }
      for (std::size_t p = 0; is_defined && p < 81; ++p) {
        // The rotation's derivative itself changes by the square of its size.
        const double gap = std::min(1.0, stretch[1] + stretch[2]);
        EXPECT_NEAR(A[lanes * p + lane], tangent[p], noise / gap) << name << ' ' << p;
      }
    }
  }
}

TEST_P(MaterialPacksTest, OneDeformationIsALane) {
  const std::vector<State> states = packs_of_states(to_inversion);
  for (std::size_t first = 0; first < states.size(); first += lanes) {
    const PackedStates packed(&states[first]);
    alignas(64) double psi[lanes], P[9 * lanes], A[81 * lanes];
    model_->energy_densities(packed.H, psi);
    model_->stresses(packed.H, P);
    model_->tangents(packed.H, A);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const Matrix H = less_identity(states[first + lane].F), stress = model_->stress(H);
      const Matrix cauchy = model_->cauchy_stress(H);
      Tangent<double> tangent;
      model_->tangent(H, tangent);
      EXPECT_EQ(model_->energy_density(H), psi[lane]);
      for (std::size_t p = 0; p < 9; ++p) EXPECT_EQ(stress.entries[p], P[lanes * p + lane]);
      for (std::size_t p = 0; p < 81; ++p) EXPECT_EQ(tangent[p], A[lanes * p + lane]);
      // P = J sigma F^-T.
      const Matrix F = states[first + lane].F, C = cofactor(F);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          double sum = 0;
          for (int k = 0; k < 3; ++k) sum += cauchy(i, k) * C(k, j);
          // J = F : C / 3 may be small among its terms.
          const double of_J = 1e-15 * norm(F) * norm(C) / std::abs(determinant(F));
          EXPECT_NEAR(sum, stress(i, j), (1e-14 + of_J) * norm(cauchy) * norm(C));
        }
    }
  }
}

/// psi = W(F) + U(J): the parts of what can be split are the whole, for psi, P and the tangent.
TEST_P(MaterialPacksTest, PartsAddUpToTheWhole) {
  const std::string name = std::get<0>(GetParam());
  EXPECT_EQ(model_->splits_volume(), name != "corotated" && name != "st_venant_kirchhoff");
  if (!model_->splits_volume()) return;
  const std::vector<State> states = packs_of_states(to_inversion);
  for (std::size_t first = 0; first < states.size(); first += lanes) {
    const PackedStates packed(&states[first]);
    alignas(64) double psi[lanes], P[9 * lanes], A[81 * lanes], W[lanes], law[3 * lanes],
        change[lanes], P_at_pressure[9 * lanes], A_at_pressure[81 * lanes];
    for (std::size_t lane = 0; lane < lanes; ++lane)
      change[lane] = deformed(states[first + lane].F).J_minus_1();
    model_->energy_densities(packed.H, psi);
    model_->stresses(packed.H, P);
    model_->tangents(packed.H, A);
    model_->distortional_energies(packed.H, W);
    model_->volumetric_laws(change, law);
    model_->stresses_at_pressure(packed.H, law + lanes, P_at_pressure);
    model_->tangents_at_pressure(packed.H, law + lanes, A_at_pressure);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const Matrix F = states[first + lane].F, C = cofactor(F);
      const double U = law[lane], curvature = law[2 * lanes + lane];
      double size = 0;
      for (std::size_t p = 0; p < 81; ++p) size = std::max(size, std::abs(A[lanes * p + lane]));
      // Of A, of F's cofactors, and of a pressure that may balance a part of W.
      const double noise = 1e-13 * size + 1e-15 * std::abs(curvature) * dot(F, F) * norm(C) +
                           1e-15 * std::abs(law[lanes + lane]) * norm(F);
      EXPECT_NEAR(W[lane] + U, psi[lane], 1e-14 * (std::abs(U) + size * (1 + dot(F, F))));
      for (std::size_t p = 0; p < 9; ++p) {
        EXPECT_NEAR(P_at_pressure[lanes * p + lane], P[lanes * p + lane],
                    1e-14 * size * (1 + norm(C)));
        for (std::size_t q = 0; q < 9; ++q) {
          const std::size_t entry = lanes * (9 * p + q) + lane;
          EXPECT_NEAR(A_at_pressure[entry] + curvature * C.entries[p] * C.entries[q], A[entry],
                      noise);
        }
      }
    }
  }
}

/// U is a function of J alone whose derivatives are what they are said to be; W knows nothing of
/// it: at a pressure of 0, stress and tangent are its derivatives.
TEST_P(MaterialPacksTest, PartsHaveTheirDerivatives) {
  if (!model_->splits_volume()) return;
  const auto law = [&](double J_minus_1) {
    alignas(64) double in[lanes], out[3 * lanes];
    std::fill_n(in, lanes, J_minus_1);
    model_->volumetric_laws(in, out);
    return std::array<double, 3>{out[0], out[lanes], out[2 * lanes]};
  };
  EXPECT_EQ(law(0)[0], 0);
  EXPECT_EQ(law(0)[1], 0) << "free of stress at rest";
  for (const double J_minus_1 : {-0.7, -0.3, -1e-3, 1e-3, 0.2, 3.0}) {
    const auto [U, slope, curvature] = law(J_minus_1);
    const double h = 1e-3 * (1 + J_minus_1);
    EXPECT_NEAR(derivative(h, [&](double s) { return law(J_minus_1 + s)[0]; }), slope,
                1e-9 * std::abs(curvature));
    EXPECT_NEAR(derivative(h, [&](double s) { return law(J_minus_1 + s)[1]; }), curvature,
                1e-9 * std::abs(curvature));
  }
  Random random(9);
  alignas(64) double H[9 * lanes], out[81 * lanes], pressure[lanes];
  const auto evaluate = [&](auto function, const Matrix &F) {
    for (std::size_t k = 0; k < 9; ++k)
      std::fill_n(H + lanes * k, lanes, less_identity(F).entries[k]);
    function();
  };
  for (const auto &[name, F, step] : all_states(to_inversion)) {
    for (const double p : {0.0, 1.7}) {
      std::fill_n(pressure, lanes, p);
      const auto energy = [&](const Matrix &at) {  // W + p J
        evaluate([&] { model_->distortional_energies(H, out); }, at);
        return out[0] + p * determinant(at);
      };
      const auto stress = [&](const Matrix &at) {
        evaluate([&] { model_->stresses_at_pressure(H, pressure, out); }, at);
        Matrix P;
        for (std::size_t k = 0; k < 9; ++k) P.entries[k] = out[lanes * k];
        return P;
      };
      const Matrix D = random.matrix(), P = stress(F);
      evaluate([&] { model_->tangents_at_pressure(H, pressure, out); }, F);
      Tangent<double> A;
      for (std::size_t k = 0; k < 81; ++k) A[k] = out[lanes * k];
      EXPECT_NEAR(derivative(step, [&](double s) { return energy(along(F, s, D)); }), dot(P, D),
                  1e-8 * (norm(P) + norm(A)))
          << name;
      const Matrix AD = test::apply(A, D);
      for (std::size_t k = 0; k < 9; ++k)
        EXPECT_NEAR(derivative(step, [&](double s) { return stress(along(F, s, D)).entries[k]; }),
                    AD.entries[k], 1e-8 * norm(A))
            << name;
    }
  }
}

std::string name_of(const testing::TestParamInfo<std::tuple<std::string, InstructionSet>> &info) {
  const char *sets[] = {"baseline", "avx2", "avx512"};
  return std::get<0>(info.param) + "_" + sets[static_cast<int>(std::get<1>(info.param))];
}

INSTANTIATE_TEST_SUITE_P(All, MaterialPacksTest,
                         testing::Combine(testing::ValuesIn(material_names()),
                                          testing::Values(InstructionSet::baseline,
                                                          InstructionSet::avx2,
                                                          InstructionSet::avx512)),
                         name_of);

/// The sentence with which a material is refused; empty if it is not.
std::string refusal(const std::string &name, const MaterialParameters &parameters) {
  try {
    make_material(name, parameters);
  } catch (const InputError &error) {
    return error.what();
  }
  return "";
}

TEST(MaterialRegistryTest, UnknownNamesAreToldTheKnownOnes) {
  const std::string sentence = refusal("jelly", {{1, 0.3}});
  EXPECT_NE(sentence.find("'jelly'"), std::string::npos);
  for (const std::string &name : material_names())
    EXPECT_NE(sentence.find(name), std::string::npos) << name;
}

TEST(MaterialRegistryTest, RefusesWhatAMaterialWouldIgnore) {
  EXPECT_NE(refusal("neo_hookean", {{1, 0.3}, 1.0}), "");
  EXPECT_NE(refusal("stable_neo_hookean", {{1, 0.3}, 1.0}), "");
  EXPECT_NE(refusal("arap", {{1, 0.3}, {}, Lame::raw}), "");
  EXPECT_EQ(refusal("stable_neo_hookean", {{1, 0.3}, {}, Lame::raw}), "");
}

TEST(MaterialRegistryTest, RefusesEnergiesWithoutALeastValue) {
  for (const char *name : {"arap", "symmetric_dirichlet", "neo_hookean"})
    EXPECT_NE(refusal(name, {{1, -0.2}}), "") << name;
  for (const char *name : {"mooney_rivlin", "arap", "symmetric_dirichlet"}) {
    EXPECT_NE(refusal(name, {{1, 0.3}, -1.0}), "") << name;
    EXPECT_EQ(refusal(name, {{1, 0.3}, 0.0}), "") << name;
  }
}

TEST(MaterialRegistryTest, ConstantsComeBackFromLames) {
  for (const double poisson : {-0.4, 0.0, 0.3, 0.495}) {
    const ElasticConstants constants{7, poisson};
    const auto [young, back] = ElasticConstants::from_lame(constants.mu(), constants.lambda());
    EXPECT_NEAR(young, 7, 1e-12);
    EXPECT_NEAR(back, poisson, 1e-13);
  }
}

/// A material of a user's, in one place: a spring to the identity.
struct Jelly {
  static constexpr const char *name = "jelly";
  double stiffness;
  explicit Jelly(const MaterialParameters &parameters) : stiffness(parameters.constants.mu()) {}

  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    return 0.5 * stiffness * squared_norm(deformation.H());
  }
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    Matrix3<Real> P = deformation.H();
    for (Real &entry : P.entries) entry = stiffness * entry;
    return P;
  }
  template <class Real>
  void tangent(const Deformation<Real> &, Tangent<Real> &A) const {
    A.fill(Real(0.0));
    add_identity(stiffness, A);
  }
};

TEST(MaterialRegistryTest, TakesMaterialsFromOutside) {
  register_material<Jelly>();
  ASSERT_EQ(material_names().back(), "jelly");
  const auto model = make_material("jelly", {ElasticConstants::from_lame(2, 0)});
  EXPECT_FALSE(model->splits_volume());
  alignas(64) double H[9 * lanes] = {}, psi[lanes];
  H[5] = 2;
  model->energy_densities(H, psi);
  EXPECT_NEAR(model->energy_density(diagonal(1, 1, 1)), 3, 1e-14);
  EXPECT_NEAR(psi[5], 4, 1e-14);
}

/// One whose energy is not 0 at rest.
struct Offset : Jelly {
  static constexpr const char *name = "offset";
  using Jelly::Jelly;
  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    return Jelly::energy_density(deformation) + 0.5;
  }
};

TEST(MaterialRegistryTest, RefusesAnEnergyThatIsNotZeroAtRest) {
  register_material<Offset>();
  EXPECT_NE(refusal("offset", {{1, 0.3}}).find("energy density 0.5 at rest"), std::string::npos);
  EXPECT_EQ(refusal("jelly", {{1, 0.3}}), "");
}

}  // namespace
}  // namespace trefoil::test
