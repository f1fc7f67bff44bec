// Materials of the registry: found by their names, and in packs, for every instruction set that
// this machine has, what they are for one deformation gradient.

#include <gtest/gtest.h>

#include <algorithm>

#include "material_cases.hpp"
#include "simd/instruction_set.hpp"
#include "trefoil/material_registry.hpp"

namespace trefoil::test {
namespace {

class MaterialPacksTest : public testing::TestWithParam<std::tuple<std::string, InstructionSet>> {
 protected:
  void SetUp() override {
    if (!processor_has(std::get<1>(GetParam()))) GTEST_SKIP() << "not on this processor";
    model_ = make_material(std::get<0>(GetParam()), {{3, 0.4}}, std::get<1>(GetParam()));
  }
  std::unique_ptr<MaterialModel> model_;
};

/// What the rounding of F itself does to a value whose derivative this is.
double noise_of(const Tangent<double> &A, const Matrix &F) {
  return 1e-13 * norm(A) * (1 + norm(F));
}

TEST_P(MaterialPacksTest, ArePlainMaterials) {
  const bool has_barrier = !std::isfinite(model_->energy_density(diagonal(1, 1, -1)));
  std::vector<State> states = all_states(endless);
  while (states.size() % lanes) states.push_back(states.front());
  for (std::size_t first = 0; first < states.size(); first += lanes) {
    alignas(64) double F[9 * lanes], psi[lanes], P[9 * lanes], A[81 * lanes];
    for (std::size_t k = 0; k < 9; ++k)
      for (std::size_t lane = 0; lane < lanes; ++lane)
        F[lanes * k + lane] = states[first + lane].F.entries[k];
    model_->energy_densities(F, psi);
    model_->stresses(F, P);
    model_->tangents(F, A);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const auto &[name, gradient, step] = states[first + lane];
      const double energy = model_->energy_density(gradient);
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
      const Matrix stress = model_->stress(gradient);
      Tangent<double> tangent;
      model_->tangent(gradient, tangent);
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
  Real energy_density(const Matrix3<Real> &F) const {
    Real sum = Real(0.0);
    for (const Real &entry : stress(F).entries) sum = sum + entry * entry;
    return sum / (2.0 * stiffness);
  }
  template <class Real>
  Matrix3<Real> stress(const Matrix3<Real> &F) const {
    Matrix3<Real> P;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) P(i, j) = stiffness * (F(i, j) - (i == j ? 1.0 : 0.0));
    return P;
  }
  template <class Real>
  void tangent(const Matrix3<Real> &, Tangent<Real> &A) const {
    A.fill(Real(0.0));
    add_identity(stiffness, A);
  }
};

TEST(MaterialRegistryTest, TakesMaterialsFromOutside) {
  register_material<Jelly>();
  ASSERT_EQ(material_names().back(), "jelly");
  const auto model = make_material("jelly", {ElasticConstants::from_lame(2, 0)});
  alignas(64) double F[9 * lanes] = {}, psi[lanes];
  model->energy_densities(F, psi);
  EXPECT_NEAR(model->energy_density(Matrix{}), 3, 1e-14);
  EXPECT_NEAR(psi[5], 3, 1e-14);
}

}  // namespace
}  // namespace trefoil::test
