// The element hook through an SNES: what its callback adds to the Jacobian is filtered, or refused
// in a sentence on all ranks. Needs petsc_main.cpp.

#include <petscdmda.h>

#include <limits>

#include "element_host.hpp"

namespace trefoil::test {
namespace {

TEST(HookHostTest, FiltersEveryJacobian) {
  const Elements elements(3, Kind::mixed);
  ElementHost host;
  host.weigh(0.7);
  ASSERT_EQ(host.solve(elements.nodes, 3, filled_with(elements), 3), 0);
  ASSERT_GE(host.matrices.size(), 1U);
  for (const Dense &matrix : host.matrices) {
    EXPECT_LT(difference(matrix, elements.sum(0.7)), 1e-13);
  }
  EXPECT_EQ(host.unfiltered(), 0);
  const double share = host.record.at("history").at(0).at("indefinite");
  EXPECT_EQ(share, elements.indefinite() / static_cast<double>(elements.all.size()));
}

/// A block that is no element of an energy, added `count` times over all ranks, and what is said.
struct Bad {
  const char *name, *sentence;
  PetscInt m, n;
  std::vector<PetscInt> rows, columns;
  Dense values;
};

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

const Bad bad_blocks[] = {
    {"RowByRow",
     "5 blocks were added to the Jacobian that are not whole elements",
     1,
     2,
     {3},
     {3, 4},
     {1, 2}},
    {"OtherColumns",
     "5 blocks were added to the Jacobian that are not whole elements",
     2,
     2,
     {3, 4},
     {4, 5},
     {1, 2, 2, 1}},
    {"Partial",
     "5 blocks were added to the Jacobian whose rows are only a part",
     2,
     3,
     {3, 4},
     {3, 4, 5},
     {1, 2, 3, 4, 5, 6}},
    {"Nonsymmetric",
     "5 of 45 element blocks are not symmetric",
     2,
     2,
     {3, 4},
     {3, 4},
     {2, 1, -1, 2}},
    {"Saddle", "5 of 45 element blocks are of a saddle point", 2, 2, {3, 4}, {3, 4}, {2, 1, 1, 0}},
    {"NotANumber",
     "5 of 45 element blocks have entries that are not finite",
     2,
     2,
     {3, 4},
     {3, 4},
     {2, nan_value, nan_value, 2}},
    {"Infinite",
     "5 of 45 element blocks have entries that are not finite",
     2,
     2,
     {3, 4},
     {3, 4},
     {infinity, 1, 1, 2}}};

class BadBlockTest : public testing::TestWithParam<Bad> {
 protected:
  /// Good elements, and five times the bad block; on the last rank alone.
  PetscErrorCode add(Mat H) const {
    const Bad &bad = GetParam();
    PetscFunctionBeginUser;
    PetscCall(MatZeroEntries(H));
    for (int i = 0; i < 5 && rank_of_world() == size_of_world() - 1; ++i) {
      PetscCall(MatSetValues(H, bad.m, bad.rows.data(), bad.n, bad.columns.data(),
                             bad.values.data(), ADD_VALUES));
    }
    PetscCall(add_elements(H, elements_, Way::values));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Elements elements_{1, Kind::mixed};
};
std::string name_of_bad(const testing::TestParamInfo<Bad> &info) {
  return info.param.name;
}
INSTANTIATE_TEST_SUITE_P(Kinds, BadBlockTest, testing::ValuesIn(bad_blocks), name_of_bad);

TEST_P(BadBlockTest, IsAnErrorOnAllRanks) {
  ElementHost host;
  const CaughtError error;
  EXPECT_NE(host.solve(elements_.nodes, 1, [this](Mat H) { return add(H); }), 0);
  EXPECT_EQ(error.sentence.rfind(GetParam().sentence, 0), 0U) << error.sentence;
}

TEST_P(BadBlockTest, PassesWhereTheUserSaysSo) {
  ElementHost host;
  host.weigh(1);
  host.option("snes_trefoil_strict", "false");
  const Bad &bad = GetParam();
  const CaughtError error;  // of the line search, where the matrix is not finite
  const PetscErrorCode code = host.solve(elements_.nodes, 1, [this](Mat H) { return add(H); });
  EXPECT_EQ(code, 0) << error.sentence;
  EXPECT_EQ(host.unfiltered(), 5);
  Dense expected = elements_.sum(1);
  for (PetscInt i = 0; i < bad.m; ++i) {
    for (PetscInt j = 0; j < bad.n; ++j) {
      expected[static_cast<std::size_t>(elements_.nodes * bad.rows[static_cast<std::size_t>(i)] +
                                        bad.columns[static_cast<std::size_t>(j)])] +=
          5 * bad.values[static_cast<std::size_t>(bad.n * i + j)];
    }
  }
  ASSERT_EQ(host.matrices.size(), 1U);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (std::isfinite(expected[i])) {
      EXPECT_NEAR(host.matrices[0][i], expected[i], 1e-11);
    } else {
      EXPECT_FALSE(std::isfinite(host.matrices[0][i]));
    }
  }
}

TEST(HookHostTest, AJacobianWithoutElementsIsAnError) {
  ElementHost host;
  const CaughtError error;
  EXPECT_NE(host.solve(6, 1, [](Mat H) { return finish_assembly(H); }), 0);
  EXPECT_EQ(error.sentence.rfind("no element block was added", 0), 0U) << error.sentence;
}

TEST(HookHostTest, AMatrixWithoutRoomForTheFilterIsAnError) {
  ElementHost host;
  host.weigh(1);
  const CaughtError error;
  EXPECT_NE(host.solve(6, 1,
                       [](Mat H) {
                         PetscFunctionBeginUser;
                         PetscCall(MatSetOption(H, MAT_IGNORE_ZERO_ENTRIES, PETSC_TRUE));
                         const PetscInt index[] = {0, 2, 5};
                         const double block[] = {1, 2, 0, 2, 1,
                                                 2, 0, 2, 1};  // whose N has no zeros
                         if (rank_of_world() == 0)
                           PetscCall(MatSetValues(H, 3, index, 3, index, block, ADD_VALUES));
                         PetscCall(finish_assembly(H));
                         PetscFunctionReturn(PETSC_SUCCESS);
                       }),
            0);
  EXPECT_EQ(error.sentence.rfind("the Jacobian has no room", 0), 0U) << error.sentence;
}

/// A bar of u-p elements on a DMDA with two unknowns a node, the second a multiplier.
class FieldsTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(DMDACreate1d(PETSC_COMM_WORLD, DM_BOUNDARY_NONE, nodes, 2, 1, nullptr, &dm_), 0);
    ASSERT_EQ(DMSetUp(dm_), 0);
    ASSERT_EQ(DMDASetFieldName(dm_, 0, "displacement"), 0);
    ASSERT_EQ(DMDASetFieldName(dm_, 1, "pressure"), 0);
  }
  void TearDown() override { EXPECT_EQ(DMDestroy(&dm_), 0); }

  /// u1 p1 u2 p2; no p-p block. The u-u block has the eigenvalues 0 and 2 c.
  static Dense element(double c) { return {c, 1, -c, 2, 1, 0, -1, 0, -c, -1, c, 3, 2, 0, 3, 0}; }
  static double stiffness(PetscInt e) { return e % 3 ? 1.0 + static_cast<double>(e) : -2.0; }

  PetscErrorCode solve(ElementHost &host) {
    PetscFunctionBeginUser;
    host.dm = dm_;
    PetscCall(DMCreateMatrix(dm_, &host.H));
    PetscCall(host.solve(nodes, 2, [](Mat H) {
      PetscFunctionBeginUser;
      PetscCall(MatZeroEntries(H));
      for (PetscInt e = rank_of_world(); e + 1 < nodes; e += size_of_world()) {
        const PetscInt index[] = {2 * e, 2 * e + 1, 2 * e + 2, 2 * e + 3};
        PetscCall(MatSetValues(H, 4, index, 4, index, element(stiffness(e)).data(), ADD_VALUES));
      }
      PetscCall(finish_assembly(H));
      PetscFunctionReturn(PETSC_SUCCESS);
    }));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  static constexpr PetscInt nodes = 9;
  DM dm_ = nullptr;
};

TEST_F(FieldsTest, OnlyTheNamedOneIsFiltered) {
  for (const char *name : {"displacement", "0"}) {
    ElementHost host;
    host.weigh(1);
    host.option("snes_trefoil_fields", name);
    ASSERT_EQ(solve(host), 0);
    Dense expected(4 * nodes * nodes, 0);
    for (PetscInt e = 0; e + 1 < nodes; ++e) {
      const Dense filtered = element(std::abs(stiffness(e)));  // absolute eigenvalues of u-u
      for (PetscInt i = 0; i < 16; ++i) {
        expected[static_cast<std::size_t>(2 * nodes * (2 * e + i / 4) + 2 * e + i % 4)] +=
            filtered[static_cast<std::size_t>(i)];
      }
    }
    ASSERT_EQ(host.matrices.size(), 1U);
    EXPECT_LT(difference(host.matrices[0], expected), 1e-13);
    EXPECT_EQ(host.record.at("history").at(0).at("indefinite"), 3.0 / 8);
  }
}

TEST_F(FieldsTest, WithoutThemASaddleIsRefused) {
  ElementHost host;
  const CaughtError error;
  EXPECT_NE(solve(host), 0);
  EXPECT_EQ(error.sentence.rfind("8 of 8 element blocks are of a saddle point", 0), 0U)
      << error.sentence;
}

TEST_F(FieldsTest, AnUnknownNameIsAnError) {
  ElementHost host;
  host.option("snes_trefoil_fields", "displacement,temperature");
  const CaughtError error;
  EXPECT_NE(solve(host), 0);
  EXPECT_NE(error.sentence.find("'temperature'"), std::string::npos) << error.sentence;
  EXPECT_NE(error.sentence.find("displacement, pressure"), std::string::npos) << error.sentence;
}

}  // namespace
}  // namespace trefoil::test
