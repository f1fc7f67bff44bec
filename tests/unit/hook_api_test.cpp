// The functions of trefoil.h for element matrices, for Mats and for rules. Needs petsc_main.cpp.

#include <limits>

#include "element_host.hpp"

namespace trefoil::test {
namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

constexpr MatOperation watched_operations[] = {
    MATOP_SET_VALUES, MATOP_SET_VALUES_BLOCKED, MATOP_SET_VALUES_LOCAL,       MATOP_ZERO_ENTRIES,
    MATOP_ZERO_ROWS,  MATOP_ZERO_ROWS_COLUMNS,  MATOP_SET_VALUES_BLOCKEDLOCAL};

std::vector<void (*)(void)> operations(Mat matrix) {
  std::vector<void (*)(void)> all;
  for (const MatOperation operation : watched_operations) {
    all.emplace_back();
    EXPECT_EQ(MatGetOperation(matrix, operation, &all.back()), 0);
  }
  return all;
}

class AttachTest : public testing::TestWithParam<const char *> {};
INSTANTIATE_TEST_SUITE_P(Types, AttachTest, testing::Values(MATAIJ, MATBAIJ, MATSBAIJ),
                         [](const auto &type) { return std::string(type.param); });

TEST_P(AttachTest, LeavesNothingBehind) {
  const Elements elements(3, Kind::mixed);
  Mat matrix = nullptr;
  MatType before = nullptr, after = nullptr;
  ASSERT_EQ(make_matrix(GetParam(), elements.nodes, 3, &matrix), 0);
  ASSERT_EQ(MatGetType(matrix, &before), 0);
  const std::string name = before;
  const auto own = operations(matrix);
  ASSERT_EQ(TrefoilMatDetach(matrix), 0);  // harmless
  for (int twice = 0; twice < 2; ++twice) {
    ASSERT_EQ(TrefoilMatAttach(matrix), 0);
    ASSERT_EQ(TrefoilMatAttach(matrix), 0);
    const auto watched = operations(matrix);
    EXPECT_NE(watched, own);
    for (std::size_t i = 0; i < own.size(); ++i) EXPECT_EQ(!watched[i], !own[i]);
    ASSERT_EQ(MatGetType(matrix, &after), 0);
    EXPECT_EQ(name, after);
    ASSERT_EQ(MatZeroEntries(matrix), 0);
    ASSERT_EQ(add_elements(matrix, elements, Way::values), 0);
    EXPECT_LT(difference(dense(matrix), elements.sum(0)), 1e-13);
    ASSERT_EQ(TrefoilMatDetach(matrix), 0);
    ASSERT_EQ(TrefoilMatDetach(matrix), 0);
    EXPECT_EQ(operations(matrix), own);
  }
  Mat copy = nullptr;  // a copy of a watched Mat is not watched
  ASSERT_EQ(TrefoilMatAttach(matrix), 0);
  ASSERT_EQ(MatDuplicate(matrix, MAT_COPY_VALUES, &copy), 0);
  EXPECT_EQ(operations(copy), own);
  ASSERT_EQ(MatDestroy(&copy), 0);
  ASSERT_EQ(MatDestroy(&matrix), 0);  // watched
}

PetscErrorCode nothing(Mat) {
  return 0;
}

// As codes do that assemble the Jacobian together with the residual.
TEST_P(AttachTest, CollectsOutsideOfCallbacks) {
  const Elements elements(3, Kind::mixed), others(3, Kind::mixed, 2);
  ElementHost host;
  host.weigh(0.6);
  ASSERT_EQ(make_matrix(GetParam(), elements.nodes, 3, &host.H), 0);
  ASSERT_EQ(MatSetOption(host.H, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE), 0);
  ASSERT_EQ(TrefoilMatAttach(host.H), 0);
  host.in_residual = [&] {
    PetscFunctionBeginUser;
    for (const Elements *added : {&others, &elements}) {  // the first ones are zeroed again
      PetscCall(MatZeroEntries(host.H));
      PetscCall(add_elements(host.H, *added, Way::values));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  };
  for (int solve = 0; solve < 2; ++solve) {
    ASSERT_EQ(host.solve(elements.nodes, 3, nothing, 2), 0);
    ASSERT_GE(host.matrices.size(), 1U);
    for (const Dense &matrix : host.matrices) {
      EXPECT_LT(difference(matrix, elements.sum(0.6)), 1e-13);
    }
  }
  // The SNES goes, the Mat is watched on: another SNES finds its elements.
  ASSERT_EQ(SNESDestroy(&host.snes), 0);
  ASSERT_EQ(host.solve(elements.nodes, 3, nothing), 0);
  ASSERT_EQ(host.matrices.size(), 1U);
  EXPECT_LT(difference(host.matrices[0], elements.sum(0.6)), 1e-13);
}

TEST(SetElementValuesTest, IsOneElementInsideACallback) {
  const Elements elements(1, Kind::mixed);
  ElementHost host;
  host.weigh(0.8);
  ASSERT_EQ(
      host.solve(elements.nodes, 1,
                 [&](Mat H) {
                   PetscFunctionBeginUser;
                   PetscCall(MatZeroEntries(H));
                   for (const Element &element : elements.mine()) {
                     const std::vector<PetscInt> index = elements.index(element);
                     PetscCall(TrefoilMatSetElementValues(H, static_cast<PetscInt>(index.size()),
                                                          index.data(), element.H.data()));
                   }
                   PetscCall(finish_assembly(H));
                   PetscFunctionReturn(PETSC_SUCCESS);
                 }),
      0);
  ASSERT_EQ(host.matrices.size(), 1U);
  EXPECT_LT(difference(host.matrices[0], elements.sum(0.8)), 1e-13);
  EXPECT_EQ(host.record.at("history").at(0).at("indefinite"),
            elements.indefinite() / static_cast<double>(elements.all.size()));
}

TEST(SetElementValuesTest, IsMatSetValuesOnAMatOfNobody) {
  const Elements elements(1, Kind::mixed);
  Mat matrix = nullptr;
  ASSERT_EQ(make_matrix(MATAIJ, elements.nodes, 1, &matrix), 0);
  const auto own = operations(matrix);
  for (const Element &element : elements.mine()) {
    const std::vector<PetscInt> index = elements.index(element);
    ASSERT_EQ(TrefoilMatSetElementValues(matrix, static_cast<PetscInt>(index.size()), index.data(),
                                         element.H.data()),
              0);
  }
  ASSERT_EQ(finish_assembly(matrix), 0);
  EXPECT_LT(difference(dense(matrix), elements.sum(0)), 1e-13);
  EXPECT_EQ(operations(matrix), own);
  ASSERT_EQ(MatDestroy(&matrix), 0);
}

TEST(SplitElementMatrixTest, IsTheFilter) {
  for (const Element &element : Elements(3, Kind::mixed).all) {
    const auto [expected, count] = Elements::split_of(element);
    const auto n = static_cast<PetscInt>(3 * element.nodes.size());
    Dense N(element.H.size(), -1);
    PetscInt negative = -1;
    ASSERT_EQ(TrefoilSplitElementMatrix(n, element.H.data(), N.data(), &negative), 0);
    EXPECT_EQ(N, expected);
    EXPECT_EQ(negative, count);
    ASSERT_EQ(TrefoilSplitElementMatrix(n, element.H.data(), N.data(), nullptr), 0);
  }
}

TEST(SplitElementMatrixTest, RefusesWhatIsNoElement) {
  Dense H(193 * 193, 1), N(193 * 193);
  for (const PetscInt n : {-1, 0, 193}) {
    const CaughtError error;
    EXPECT_EQ(TrefoilSplitElementMatrix(n, H.data(), N.data(), nullptr), PETSC_ERR_ARG_OUTOFRANGE);
    EXPECT_EQ(error.sentence, "an element matrix has 1 to 192 rows, not " + std::to_string(n));
  }
  const CaughtError error;
  H[1] = nan_value;
  EXPECT_EQ(TrefoilSplitElementMatrix(2, H.data(), N.data(), nullptr), PETSC_ERR_FP);
  EXPECT_EQ(error.sentence, "the element matrix has entries that are not finite");
}

/// What a rule of the host's was told, and what it answers.
struct OwnRule {
  double weight = 0.25;
  PetscErrorCode code = 0;
  std::vector<double> told;  ///< the last iteration's weight, -1 where there is none
};

PetscErrorCode ask(SNES, const TrefoilIteration *last, PetscReal *weight, void *context) {
  auto &rule = *static_cast<OwnRule *>(context);
  rule.told.push_back(last ? last->weight : -1);
  *weight = rule.weight;
  return rule.code;
}

TEST(RuleRegisterTest, ChoosesTheWeights) {
  const Elements elements(1, Kind::mixed);
  OwnRule rule;
  ASSERT_EQ(TrefoilRuleRegister("host's own", ask, &rule), 0);
  ElementHost host;
  host.option("snes_trefoil_filter", "host's own");
  host.option("snes_linesearch_damping", "0.5");
  ASSERT_EQ(host.solve(elements.nodes, 1, filled_with(elements), 3), 0);
  EXPECT_EQ(rule.told, (std::vector<double>{-1, 0.25, 0.25}));
  ASSERT_EQ(host.matrices.size(), 3U);
  for (const Dense &matrix : host.matrices) {
    EXPECT_LT(difference(matrix, elements.sum(0.25)), 1e-13);
  }
}

TEST(RuleRegisterTest, ANameIsGivenOnce) {
  OwnRule rule;
  ASSERT_EQ(TrefoilRuleRegister("only once", ask, &rule), 0);
  for (const std::string name : {"only once", "clamp", "adaptive"}) {
    const CaughtError error;
    EXPECT_NE(TrefoilRuleRegister(name.c_str(), ask, &rule), 0);
    EXPECT_EQ(error.sentence, "there is a rule '" + name + "' already");
  }
}

TEST(RuleRegisterTest, AWeightThatIsNoneIsAnError) {
  OwnRule rule;
  ASSERT_EQ(TrefoilRuleRegister("no good", ask, &rule), 0);
  for (const double weight : {-0.1, nan_value}) {
    rule.weight = weight;
    ElementHost host;
    host.option("snes_trefoil_filter", "no good");
    const CaughtError error;
    EXPECT_NE(host.solve(6, 1, nothing), 0);
    EXPECT_EQ(error.sentence.rfind("rule 'no good' chose the weight", 0), 0U) << error.sentence;
  }
}

TEST(RuleRegisterTest, AHostsOwnErrorCodeSurvives) {
  OwnRule rule;
  ASSERT_EQ(TrefoilRuleRegister("fails", ask, &rule), 0);
  for (const PetscErrorCode code : {PETSC_ERR_USER, PETSC_ERR_FILE_OPEN}) {
    rule.code = code;
    ElementHost host;
    host.option("snes_trefoil_filter", "fails");
    const CaughtError error;
    EXPECT_EQ(host.solve(6, 1, nothing), code);
  }
}

}  // namespace
}  // namespace trefoil::test
