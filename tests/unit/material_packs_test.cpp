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

/// Planes H + a D + b S of deformations, one in each lane.
struct PackedPlanes {
  Matrix H[lanes], D[lanes], S[lanes];
  alignas(64) double packed[3][9 * lanes];

  /// @param rotation what the body has turned by; in the plane nothing moves in the third direction
  PackedPlanes(double size, int dimension, const Matrix &rotation, Random *random) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const auto turned = [&] {
        Matrix A = random->matrix(size);
        for (int i = dimension; i < 3; ++i)
          for (int j = 0; j < 3; ++j) A(i, j) = A(j, i) = 0;
        return rotation * A;
      };
      H[lane] = along(turned(), 1, less_identity(rotation));
      D[lane] = turned();
      S[lane] = turned();
      for (std::size_t p = 0; p < 9; ++p) {
        packed[0][lanes * p + lane] = H[lane].entries[p];
        packed[1][lanes * p + lane] = D[lane].entries[p];
        packed[2][lanes * p + lane] = S[lane].entries[p];
      }
    }
  }
};

void expect_changes_are_differences(const MaterialModel &model, const PackedPlanes &planes) {
  const std::vector<PlanePoint> points = {{0, 0},    {1, 0},      {0, 1},     {2, 0},
                                          {0.5, -1}, {-0.4, 0.3}, {1.7, 0.9}, {2, 1}};
  const double weight[lanes] = {1, 2, 3, 4, 5, 6, 7, 8};
  std::vector<double> changes(lanes * points.size(), 0);
  model.energy_changes(planes.packed[0], planes.packed[1], planes.packed[2], points, weight,
                       changes.data());
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const std::size_t lane = k % lanes;
    const PlanePoint &point = points[k / lanes];
    const Matrix H =
        along(along(planes.H[lane], point.a(), planes.D[lane]), point.b(), planes.S[lane]);
    const double before = model.energy_density(planes.H[lane]), after = model.energy_density(H);
    if (!std::isfinite(after)) {
      EXPECT_FALSE(std::isfinite(changes[k])) << point.a() << ' ' << point.b();
      continue;
    }
    if (Deformation<double>(H).J() < 0.02) continue;  // some energies are divided by it
    const double noise_of_H = 3e-15 * norm(model.stress(H)) * (1 + norm(H));
    EXPECT_NEAR(changes[k], weight[lane] * (after - before),
                weight[lane] * (1e-11 * (after + before) + noise_of_H))
        << point.a() << ' ' << point.b();
  }
}

/// In a plane of deformations the energy may be known by its invariants all at once; one energy
/// after the other says the same, and with the digits that small strains have, turned or not.
TEST_P(MaterialPacksTest, ChangesInAPlaneAreDifferencesOfEnergies) {
  Random random(7);
  Matrix quarter_turn = diagonal(0, 0, 1);
  quarter_turn(0, 1) = -1, quarter_turn(1, 0) = 1;
  const Matrix rotation = random.rotation(), none = diagonal(1, 1, 1);
  for (const double size : {0.2, 1e-3, 1e-7}) {
    SCOPED_TRACE(size);
    expect_changes_are_differences(*model_, PackedPlanes(size, 2, none, &random));
    expect_changes_are_differences(*model_, PackedPlanes(size, 2, quarter_turn, &random));
    expect_changes_are_differences(*model_, PackedPlanes(size, 3, none, &random));
    expect_changes_are_differences(*model_, PackedPlanes(size, 3, rotation, &random));
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
