// What a host does to its Jacobian when the elements are in: what is solved with is the filtered
// Hessian all the same, or a sentence says that it cannot be. Needs petsc_main.cpp.

#include <functional>

#include "element_host.hpp"

namespace trefoil::test {
namespace {

constexpr double weight = 0.7;

/// Every third number in turn, never zero: a vector that has its own number for each row.
double factor_of(PetscInt i) {
  return 0.5 + 0.25 * static_cast<double>(i % 3);
}
PetscErrorCode make_factors(Mat H, double sign, Vec *factors) {
  PetscInt begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(MatCreateVecs(H, factors, nullptr));
  PetscCall(VecGetOwnershipRange(*factors, &begin, &end));
  for (PetscInt i = begin; i < end; ++i)
    PetscCall(VecSetValue(*factors, i, i % 2 ? factor_of(i) : sign * factor_of(i), INSERT_VALUES));
  PetscCall(VecAssemblyBegin(*factors));
  PetscCall(VecAssemblyEnd(*factors));
  PetscFunctionReturn(PETSC_SUCCESS);
}

using Change = std::function<PetscErrorCode(Mat)>;

/// Solves with elements and then `change`; the matrix that KSP got in the last Jacobian.
PetscErrorCode solve(ElementHost &host, const Elements &elements, const Change &change,
                     PetscInt iterations = 2) {
  host.weigh(weight);
  host.option("snes_linesearch_damping", "0.5");  // so that there is a second Jacobian
  return host.solve(
      elements.nodes, elements.block,
      [&](Mat H) {
        PetscFunctionBeginUser;
        PetscCall(MatZeroEntries(H));
        PetscCall(add_elements(H, elements, Way::values));
        PetscCall(change(H));
        PetscFunctionReturn(PETSC_SUCCESS);
      },
      iterations);
}

/// Dense sums with something done to each number.
Dense changed(const Elements &elements, double w,
              const std::function<double(PetscInt, PetscInt, double)> &change) {
  Dense result = elements.sum(w);
  const PetscInt n = elements.unknowns();
  for (PetscInt i = 0; i < n; ++i)
    for (PetscInt j = 0; j < n; ++j) {
      double &value = result[static_cast<std::size_t>(n * i + j)];
      value = change(i, j, value);
    }
  return result;
}

struct Carried {
  const char *name;
  Change change;
  /// From H + 2 w N to what is right.
  std::function<double(PetscInt, PetscInt, double)> expected;
  bool negated = false;  ///< then H + 2 w N of the elements' negatives is what is changed
};

/// sum of -H_e + 2 w N(-H_e) = -H + 2 w (H + N) = (2 w - 1) H + 2 w N.
Dense negated_sum(const Elements &elements) {
  Dense H = elements.sum(0);
  const Dense both = elements.sum(weight);
  for (std::size_t i = 0; i < H.size(); ++i) H[i] = both[i] + (2 * weight - 2) * H[i];
  return H;
}

const Carried carried[] = {
    {"Scaled", [](Mat H) { return MatScale(H, 1e-3); },
     [](PetscInt, PetscInt, double value) { return 1e-3 * value; }},
    {"ScaledTwice",
     [](Mat H) {
       PetscFunctionBeginUser;
       PetscCall(MatScale(H, 20));
       PetscCall(MatScale(H, 5));
       PetscFunctionReturn(PETSC_SUCCESS);
     },
     [](PetscInt, PetscInt, double value) { return 100 * value; }},
    {"Negated", [](Mat H) { return MatScale(H, -1); },
     [](PetscInt, PetscInt, double value) { return value; }, true},
    {"NegatedAndShifted",
     [](Mat H) {
       PetscFunctionBeginUser;
       PetscCall(MatScale(H, -2));
       PetscCall(MatShift(H, 3));
       PetscFunctionReturn(PETSC_SUCCESS);
     },
     [](PetscInt i, PetscInt j, double value) { return 2 * value + (i == j ? 3 : 0); }, true},
    {"NegatedTwice",
     [](Mat H) {
       PetscFunctionBeginUser;
       PetscCall(MatScale(H, -1));
       PetscCall(MatScale(H, -1));
       PetscFunctionReturn(PETSC_SUCCESS);
     },
     [](PetscInt, PetscInt, double value) { return value; }},
    {"Shifted", [](Mat H) { return MatShift(H, 3); },
     [](PetscInt i, PetscInt j, double value) { return value + (i == j ? 3 : 0); }},
    {"ShiftedDown", [](Mat H) { return MatShift(H, -3); },
     [](PetscInt i, PetscInt j, double value) {
       return value + (i == j ? -3 + 2 * weight * 3 : 0);
     }},
    {"DiagonallyScaled",
     [](Mat H) {
       Vec factors = nullptr;
       PetscFunctionBeginUser;
       PetscCall(make_factors(H, 1, &factors));
       PetscCall(MatDiagonalScale(H, factors, factors));
       PetscCall(VecDestroy(&factors));
       PetscFunctionReturn(PETSC_SUCCESS);
     },
     [](PetscInt i, PetscInt j, double value) { return factor_of(i) * value * factor_of(j); }},
    {"WithADiagonal",
     [](Mat H) {
       Vec factors = nullptr;
       PetscFunctionBeginUser;
       PetscCall(make_factors(H, -1, &factors));
       PetscCall(MatDiagonalSet(H, factors, ADD_VALUES));
       PetscCall(VecDestroy(&factors));
       PetscFunctionReturn(PETSC_SUCCESS);
     },
     [](PetscInt i, PetscInt j, double value) {
       if (i != j) return value;
       return value + (i % 2 ? 1 : 2 * weight - 1) * factor_of(i);
     }},
    {"WithSpringsToTheGround",
     [](Mat H) {
       PetscInt begin = 0, end = 0;
       PetscFunctionBeginUser;
       PetscCall(MatGetOwnershipRange(H, &begin, &end));
       for (PetscInt i = begin; i < end; ++i)
         PetscCall(MatSetValue(H, i, i, i % 2 ? 2 : -2, ADD_VALUES));
       PetscCall(finish_assembly(H));
       PetscFunctionReturn(PETSC_SUCCESS);
     },
     [](PetscInt i, PetscInt j, double value) {
       if (i != j) return value;
       return value + (i % 2 ? 2 : -2 + 2 * weight * 2);
     }}};

class CarriedTest : public testing::TestWithParam<Carried> {};
INSTANTIATE_TEST_SUITE_P(Changes, CarriedTest, testing::ValuesIn(carried),
                         [](const auto &each) { return std::string(each.param.name); });

TEST_P(CarriedTest, GoesToTheNegativePartToo) {
  const Elements elements(2, Kind::mixed);
  ElementHost host;
  const CaughtError error;
  ASSERT_EQ(solve(host, elements, GetParam().change), 0) << error.sentence;
  Dense expected = changed(elements, weight, GetParam().expected);
  if (GetParam().negated) {
    expected = negated_sum(elements);
    const PetscInt n = elements.unknowns();
    for (PetscInt i = 0; i < n; ++i)
      for (PetscInt j = 0; j < n; ++j) {
        double &value = expected[static_cast<std::size_t>(n * i + j)];
        value = GetParam().expected(i, j, value);
      }
  }
  ASSERT_GE(host.matrices.size(), 2U);
  for (const Dense &matrix : host.matrices) EXPECT_LT(difference(matrix, expected), 1e-11);
  EXPECT_EQ(host.unfiltered(), 0);
}

/// A copy of the Mat with other numbers.
PetscErrorCode copy_of(Mat H, double factor, Mat *copy) {
  PetscFunctionBeginUser;
  PetscCall(MatDuplicate(H, MAT_COPY_VALUES, copy));
  PetscCall(MatScale(*copy, factor));
  PetscFunctionReturn(PETSC_SUCCESS);
}

struct Refused {
  const char *name, *words;
  Change change;
};

const Refused refused[] = {
    {"Axpy", "is not the sum of the 40 element blocks",
     [](Mat H) {
       Mat other = nullptr;
       PetscFunctionBeginUser;
       PetscCall(copy_of(H, 1e-3, &other));
       PetscCall(MatAXPY(H, 1, other, SAME_NONZERO_PATTERN));
       PetscCall(MatDestroy(&other));
       PetscFunctionReturn(PETSC_SUCCESS);
     }},
    {"Copy", "is not the sum of the 40 element blocks",
     [](Mat H) {
       Mat other = nullptr;
       PetscFunctionBeginUser;
       PetscCall(copy_of(H, -1, &other));
       PetscCall(MatCopy(other, H, SAME_NONZERO_PATTERN));
       PetscCall(MatDestroy(&other));
       PetscFunctionReturn(PETSC_SUCCESS);
     }},
    {"NumberByNumber", "single numbers were added beside",
     [](Mat H) {
       PetscFunctionBeginUser;
       if (rank_of_world() == 0) {
         PetscCall(MatSetValue(H, 0, 1, -2, ADD_VALUES));
         PetscCall(MatSetValue(H, 1, 0, -2, ADD_VALUES));
       }
       PetscCall(finish_assembly(H));
       PetscFunctionReturn(PETSC_SUCCESS);
     }},
    {"ScaledByRows", "scaled by rows or by columns alone",
     [](Mat H) {
       Vec factors = nullptr;
       PetscFunctionBeginUser;
       PetscCall(make_factors(H, 1, &factors));
       PetscCall(MatDiagonalScale(H, factors, nullptr));
       PetscCall(VecDestroy(&factors));
       PetscFunctionReturn(PETSC_SUCCESS);
     }},
    {"InsertedOver", "is not the sum of the 40 element blocks", [](Mat H) {
       const PetscInt index[] = {2, 3};
       const PetscScalar values[] = {9, 1, 1, 9};
       PetscFunctionBeginUser;
       if (rank_of_world() == 0)
         PetscCall(MatSetValues(H, 2, index, 2, index, values, INSERT_VALUES));
       PetscCall(finish_assembly(H));
       PetscFunctionReturn(PETSC_SUCCESS);
     }}};

class RefusedTest : public testing::TestWithParam<Refused> {};
INSTANTIATE_TEST_SUITE_P(Changes, RefusedTest, testing::ValuesIn(refused),
                         [](const auto &each) { return std::string(each.param.name); });

TEST_P(RefusedTest, IsSaidInASentence) {
  const Elements elements(2, Kind::mixed);
  ElementHost host;
  const CaughtError error;
  EXPECT_EQ(solve(host, elements, GetParam().change), PETSC_ERR_SUP);
  EXPECT_NE(error.sentence.find(GetParam().words), std::string::npos) << error.sentence;
}

TEST_P(RefusedTest, PassesWhereTheUserSaysSo) {
  const Elements elements(2, Kind::mixed);
  ElementHost host;
  host.option("snes_trefoil_strict", "false");
  const CaughtError error;
  ASSERT_EQ(solve(host, elements, GetParam().change, 1), 0) << error.sentence;
  EXPECT_GT(host.unfiltered(), 0);
}

// In the manner of PETSc's ex16: zeroed by a factor, and Dirichlet rows as inserted blocks.
TEST(BoundaryTest, DiagonalBlocksThatAreInsertedAreNoChange) {
  const Elements elements(2, Kind::mixed);
  ElementHost host;
  const CaughtError error;
  host.weigh(weight);
  host.option("snes_linesearch_damping", "0.5");
  ASSERT_EQ(host.solve(
                elements.nodes, elements.block,
                [&](Mat H) {
                  const PetscInt index[] = {2, 3};
                  const PetscScalar one[] = {1, 0, 0, 1};
                  PetscFunctionBeginUser;
                  PetscBool assembled = PETSC_FALSE;
                  PetscCall(MatAssembled(H, &assembled));
                  if (assembled) PetscCall(MatScale(H, 0));
                  PetscCall(add_elements(H, elements, Way::values));
                  PetscCall(MatAssemblyBegin(H, MAT_FLUSH_ASSEMBLY));
                  PetscCall(MatAssemblyEnd(H, MAT_FLUSH_ASSEMBLY));
                  if (rank_of_world() == 0)
                    PetscCall(MatSetValues(H, 2, index, 2, index, one, INSERT_VALUES));
                  PetscCall(finish_assembly(H));
                  PetscFunctionReturn(PETSC_SUCCESS);
                },
                3),
            0)
      << error.sentence;
  EXPECT_GE(host.matrices.size(), 2U);
  EXPECT_EQ(host.unfiltered(), 0);
}

class ZeroedTest : public testing::TestWithParam<bool> {
 protected:
  /// Rows 1 and 5, by the rank that has them.
  static PetscErrorCode zero(Mat H, bool columns_too) {
    PetscInt begin = 0, end = 0;
    std::vector<PetscInt> rows;
    PetscFunctionBeginUser;
    PetscCall(MatGetOwnershipRange(H, &begin, &end));
    for (const PetscInt row : {1, 5})
      if (begin <= row && row < end) rows.push_back(row);
    const auto function = columns_too ? MatZeroRowsColumns : MatZeroRows;
    PetscCall(MatSetOption(H, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
    PetscCall(function(H, static_cast<PetscInt>(rows.size()), rows.data(), 1.5, nullptr, nullptr));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
};
INSTANTIATE_TEST_SUITE_P(Columns, ZeroedTest, testing::Bool());

TEST_P(ZeroedTest, RowsOfTheHostAreNoChange) {
  const Elements elements(2, Kind::mixed);
  ElementHost host;
  const CaughtError error;
  EXPECT_EQ(solve(
                host, elements, [](Mat H) { return zero(H, GetParam()); }, 3),
            0)
      << error.sentence;
  EXPECT_GE(host.matrices.size(), 2U);
}

TEST_P(ZeroedTest, AChangeBesideThemIsNoticedOnceTheyAreKnown) {
  const Elements elements(2, Kind::mixed);
  ElementHost host;
  const CaughtError error;
  EXPECT_EQ(solve(
                host, elements,
                [](Mat H) {
                  PetscFunctionBeginUser;
                  PetscCall(zero(H, GetParam()));
                  PetscCall(refused[0].change(H));
                  PetscFunctionReturn(PETSC_SUCCESS);
                },
                3),
            PETSC_ERR_SUP);
  EXPECT_EQ(host.matrices.size(), 1U);
}

// Perturbed u-p elements: the multiplier's block is there, and negative definite.
TEST(SaddleTest, ANegativeDefiniteBlockOfMultipliersIsRefused) {
  ElementHost host;
  const CaughtError error;
  constexpr PetscInt nodes = 20;
  EXPECT_NE(host.solve(nodes, 2,
                       [](Mat H) {
                         PetscFunctionBeginUser;
                         PetscCall(MatZeroEntries(H));
                         for (PetscInt e = rank_of_world(); e + 1 < nodes; e += size_of_world()) {
                           const PetscInt index[] = {2 * e, 2 * e + 1, 2 * e + 2, 2 * e + 3};
                           const double c = 1 + static_cast<double>(e % 4);
                           const PetscScalar block[] = {c,  1,  -c, 2, 1, -.1, -1, 0,
                                                        -c, -1, c,  3, 2, 0,   3,  -.1};
                           PetscCall(MatSetValues(H, 4, index, 4, index, block, ADD_VALUES));
                         }
                         PetscCall(finish_assembly(H));
                         PetscFunctionReturn(PETSC_SUCCESS);
                       }),
            0);
  EXPECT_NE(error.sentence.find("19 of 19 element blocks are of a saddle point"), std::string::npos)
      << error.sentence;
}

// In one dimension every unknown of a concave element has a negative diagonal, and is meant.
TEST(SaddleTest, ConcaveElementsAreNone) {
  ElementHost host;
  const CaughtError error;
  constexpr PetscInt nodes = 20;
  host.weigh(1);
  ASSERT_EQ(host.solve(nodes, 1,
                       [](Mat H) {
                         PetscFunctionBeginUser;
                         PetscCall(MatZeroEntries(H));
                         for (PetscInt e = rank_of_world(); e + 1 < nodes; e += size_of_world()) {
                           const PetscInt index[] = {e, e + 1};
                           const PetscScalar block[] = {-1, 1, 1, -1};
                           PetscCall(MatSetValues(H, 2, index, 2, index, block, ADD_VALUES));
                         }
                         PetscCall(finish_assembly(H));
                         PetscFunctionReturn(PETSC_SUCCESS);
                       }),
            0)
      << error.sentence;
  EXPECT_NEAR(host.matrices.at(0)[0], 1, 1e-14);
}

}  // namespace
}  // namespace trefoil::test
