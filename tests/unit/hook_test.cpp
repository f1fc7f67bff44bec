// The element hook on Mats of every type and for every way to add an element, against dense sums.
// Needs petsc_main.cpp.

#include <petscmat.h>

#include "element_matrices.hpp"
#include "hook/matrix_operations.hpp"

namespace trefoil::test {
namespace {

/// A host's Mat with the hook on it, and what one callback after the other leaves.
class WatchedMatrix {
 public:
  WatchedMatrix(const std::string &type, const Elements &elements) : elements_(elements) {
    EXPECT_EQ(make_matrix(type, elements.nodes, elements.block, &H), 0);
  }
  ~WatchedMatrix() {
    static_cast<void>(MatDestroy(&H));
    static_cast<void>(MatDestroy(&N));
  }
  WatchedMatrix(const WatchedMatrix &) = delete;
  WatchedMatrix &operator=(const WatchedMatrix &) = delete;

  /// One callback under watch: what `host` does with H, from zero.
  template <class Callback>
  void callback(const Callback &host) {
    ElementHook *hook = nullptr;
    double seconds = -1;
    ASSERT_EQ(ElementHook::attach(H, &hook), 0);
    ASSERT_EQ(hook->begin(N, nullptr), 0);
    ASSERT_EQ(MatZeroEntries(H), 0);
    ASSERT_EQ(MatSetOption(H, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE), 0);
    ASSERT_EQ(host(H), 0);
    ASSERT_EQ(hook->end(H, &N, &counts, &seconds), 0);
    EXPECT_FALSE(hook->active());
    EXPECT_GE(seconds, 0);
  }
  void assemble(Way way) {
    callback([&](Mat matrix) { return add_elements(matrix, elements_, way); });
  }

  void add_negative(double weight) { ASSERT_EQ(add_multiple(H, 2 * weight, N), 0); }

  Mat H = nullptr, N = nullptr;
  InsertionCounts counts;

 private:
  const Elements &elements_;
};

struct Setting {
  const char *type;
  PetscInt block;
  Way way;
};

std::string name_of(const testing::TestParamInfo<Setting> &info) {
  constexpr const char *ways[] = {"Values", "Blocked", "Local", "BlockedLocal"};
  return std::string(info.param.type) + std::to_string(info.param.block) +
         ways[static_cast<int>(info.param.way)];
}

std::vector<Setting> settings() {
  std::vector<Setting> all;
  for (const char *type : {MATAIJ, MATBAIJ, MATSBAIJ})
    for (const PetscInt block : {1, 3})
      for (const Way way : {Way::values, Way::blocked, Way::local, Way::blocked_local})
        all.push_back({type, block, way});
  return all;
}

class HookTest : public testing::TestWithParam<Setting> {};
INSTANTIATE_TEST_SUITE_P(Types, HookTest, testing::ValuesIn(settings()), name_of);

TEST_P(HookTest, SumsNegativePartsOfElements) {
  const Elements elements(GetParam().block, Kind::mixed);
  WatchedMatrix matrix(GetParam().type, elements);
  for (int repeat = 0; repeat < 3; ++repeat) {  // the first stashes N, the others have it
    matrix.assemble(GetParam().way);
    EXPECT_EQ(matrix.counts.elements, static_cast<PetscInt64>(elements.all.size()));
    EXPECT_EQ(matrix.counts.indefinite, elements.indefinite());
    EXPECT_GT(matrix.counts.indefinite, 10);
    EXPECT_EQ(matrix.counts.unfiltered(), 0);
    ASSERT_NE(matrix.N, nullptr);
    EXPECT_LT(difference(dense(matrix.H), elements.sum(0)), 1e-13);
    matrix.add_negative(0.7);
    EXPECT_LT(difference(dense(matrix.H), elements.sum(0.7)), 1e-13);
  }
}

TEST_P(HookTest, FromWeightToWeightIsAsAssembledAnew) {
  const Elements elements(GetParam().block, Kind::mixed);
  WatchedMatrix stepped(GetParam().type, elements), anew(GetParam().type, elements);
  stepped.assemble(GetParam().way);
  stepped.add_negative(0.5);
  stepped.add_negative(1 - 0.5);
  anew.assemble(GetParam().way);
  anew.add_negative(1);
  EXPECT_LT(difference(dense(stepped.H), dense(anew.H)), 1e-14);
}

TEST_P(HookTest, MakesNoMatrixWhereNothingIsNegative) {
  const Elements positive(GetParam().block, Kind::positive);
  const Elements mixed(GetParam().block, Kind::mixed);
  WatchedMatrix matrix(GetParam().type, positive);
  matrix.assemble(GetParam().way);
  EXPECT_EQ(matrix.counts.elements, static_cast<PetscInt64>(positive.all.size()));
  EXPECT_EQ(matrix.counts.indefinite, 0);
  EXPECT_EQ(matrix.N, nullptr);
  EXPECT_LT(difference(dense(matrix.H), positive.sum(0)), 1e-13);
  // And one that has been made is empty afterwards.
  matrix.callback([&](Mat H) { return add_elements(H, mixed, GetParam().way); });
  ASSERT_NE(matrix.N, nullptr);
  matrix.assemble(GetParam().way);
  PetscReal norm = -1;
  EXPECT_EQ(MatNorm(matrix.N, NORM_FROBENIUS, &norm), 0);
  EXPECT_EQ(norm, 0);
}

/// The same without these rows, and columns if asked, and with `diagonal` there.
Dense zeroed(Dense matrix, const std::vector<PetscInt> &rows, bool columns_too, double diagonal) {
  const auto n =
      static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(matrix.size()))));
  for (const PetscInt row : rows) {
    const auto r = static_cast<std::size_t>(row);
    for (std::size_t i = 0; i < n; ++i) {
      matrix[n * r + i] = 0;
      if (columns_too) matrix[n * i + r] = 0;
    }
    matrix[n * r + r] = diagonal;
  }
  return matrix;
}

struct Zeroing {
  const char *type;
  bool columns_too, keep_pattern;
};

std::string name_of_zeroing(const testing::TestParamInfo<Zeroing> &info) {
  const Zeroing &zeroing = info.param;
  return std::string(zeroing.type) + (zeroing.columns_too ? "RowsColumns" : "Rows") +
         (zeroing.keep_pattern ? "" : "Shrinking");
}

class ZeroRowsTest : public testing::TestWithParam<Zeroing> {};
INSTANTIATE_TEST_SUITE_P(Types, ZeroRowsTest,
                         testing::Values(Zeroing{MATAIJ, false, true}, Zeroing{MATAIJ, true, true},
                                         Zeroing{MATAIJ, true, false},
                                         Zeroing{MATAIJ, false, false},
                                         Zeroing{MATBAIJ, false, true},
                                         Zeroing{MATBAIJ, true, true},
                                         Zeroing{MATSBAIJ, true, true}),
                         name_of_zeroing);

TEST_P(ZeroRowsTest, OfTheHostAreZeroInTheNegativePart) {
  const auto &[type, columns_too, keep] = GetParam();
  const Elements elements(3, Kind::mixed);
  WatchedMatrix matrix(type, elements);
  PetscBool able = PETSC_FALSE;
  ASSERT_EQ(
      MatHasOperation(matrix.H, columns_too ? MATOP_ZERO_ROWS_COLUMNS : MATOP_ZERO_ROWS, &able), 0);
  if (!able) GTEST_SKIP() << "PETSc has no such operation for this type";
  ASSERT_EQ(MatSetOption(matrix.H, MAT_KEEP_NONZERO_PATTERN, keep ? PETSC_TRUE : PETSC_FALSE), 0);
  // Each rank names rows, some of them not its own, and in two calls.
  const std::vector<PetscInt> first{2, 5, 40}, second{17, 18};
  for (int repeat = 0; repeat < 3; ++repeat) {
    matrix.callback([&, zero = columns_too ? MatZeroRowsColumns : MatZeroRows](Mat H) {
      const bool last = rank_of_world() == size_of_world() - 1;
      PetscFunctionBeginUser;
      PetscCall(add_elements(H, elements, Way::values));
      PetscCall(zero(H, last ? 3 : 0, first.data(), 2.5, nullptr, nullptr));
      PetscCall(zero(H, last ? 0 : 2, second.data(), 2.5, nullptr, nullptr));
      if (size_of_world() == 1) PetscCall(zero(H, 2, second.data(), 2.5, nullptr, nullptr));
      PetscFunctionReturn(PETSC_SUCCESS);
    });
    const std::vector<PetscInt> all{2, 5, 40, 17, 18};
    const Dense H = zeroed(elements.sum(0), all, columns_too, 2.5);
    EXPECT_LT(difference(dense(matrix.H), H), 1e-13);
    matrix.add_negative(1);
    EXPECT_LT(difference(dense(matrix.H), zeroed(elements.sum(1), all, columns_too, 2.5)), 1e-13)
        << "callback " << repeat;
  }
}

TEST(QuietHookTest, WhatIsNoElementPasses) {
  const Elements elements(3, Kind::mixed);
  WatchedMatrix matrix(MATAIJ, elements);
  const Element element = elements.all[1];
  const std::vector<PetscInt> index = elements.index(element);
  const auto n = static_cast<PetscInt>(index.size());
  // Between callbacks.
  matrix.assemble(Way::values);
  ASSERT_EQ(add_element(matrix.H, elements, element, Way::values), 0);
  ASSERT_EQ(finish_assembly(matrix.H), 0);
  // Numbers one by one, and fills.
  matrix.callback([&](Mat H) {
    const double minus = -1;
    PetscInt own[2] = {0, 0};
    PetscFunctionBeginUser;
    PetscCall(MatGetOwnershipRange(H, &own[0], nullptr));
    own[1] = own[0] + 1;
    PetscCall(MatSetValues(H, n, index.data(), n, index.data(), element.H.data(), INSERT_VALUES));
    PetscCall(MatSetValues(H, 2, own, 2, own, nullptr, INSERT_VALUES));
    PetscCall(MatAssemblyBegin(H, MAT_FLUSH_ASSEMBLY));
    PetscCall(MatAssemblyEnd(H, MAT_FLUSH_ASSEMBLY));
    for (const PetscInt i : index) PetscCall(MatSetValues(H, 1, &i, 1, &i, &minus, ADD_VALUES));
    PetscCall(finish_assembly(H));
    PetscFunctionReturn(PETSC_SUCCESS);
  });
  EXPECT_EQ(matrix.counts.elements, 0);
  // The block that was inserted is not among what was added, and that is noticed.
  EXPECT_EQ(matrix.counts.changed, 1);
  EXPECT_EQ(matrix.counts.unfiltered(), 1);
  // A number on the diagonal is an element of one unknown.
  const auto size = static_cast<std::size_t>(elements.unknowns());
  Dense N(size * size, 0);
  for (const PetscInt i : index) {
    if (i >= 0) N[static_cast<std::size_t>(i) * (size + 1)] = size_of_world();
  }
  EXPECT_LT(difference(dense(matrix.N), N), 1e-15);
  // Nothing of all that is left over.
  matrix.assemble(Way::values);
  matrix.add_negative(1);
  EXPECT_LT(difference(dense(matrix.H), elements.sum(1)), 1e-13);
}

// Off the elements' pattern, N must not be added as if it had H's: BLAS would not notice.
TEST(PatternTest, FollowsTheHostsMatrix) {
  Elements few(1, Kind::mixed, 1), many(1, Kind::mixed, 2);
  few.all.resize(8);  // leaves zeros
  many.all.resize(12);
  WatchedMatrix matrix(MATAIJ, few);
  matrix.assemble(Way::values);
  for (const Elements *elements : {&many, &few, &many}) {  // H's pattern widens once
    matrix.callback([&](Mat H) { return add_elements(H, *elements, Way::values); });
    matrix.add_negative(1);
    EXPECT_LT(difference(dense(matrix.H), elements->sum(1)), 1e-13);
  }
}

// MatAXPY() with another pattern makes the Mat anew and forgets what was composed with it, but not
// the operations: the hook must live on.
TEST(PatternTest, OfAMatThatIsMadeAnewIsWatchedOn) {
  const Elements elements(1, Kind::mixed);
  Mat other = nullptr;
  ASSERT_EQ(make_matrix(MATAIJ, elements.nodes, 1, &other), 0);
  for (PetscInt i = 0; i < elements.nodes; ++i) {
    ASSERT_EQ(MatSetValue(other, i, (3 * i) % elements.nodes, 0, INSERT_VALUES), 0);
  }
  ASSERT_EQ(finish_assembly(other), 0);
  WatchedMatrix matrix(MATAIJ, elements);
  for (int repeat = 0; repeat < 2; ++repeat) {
    matrix.callback([&](Mat H) {
      PetscFunctionBeginUser;
      PetscCall(finish_assembly(H));
      PetscCall(MatAXPY(H, 1, other, DIFFERENT_NONZERO_PATTERN));
      PetscCall(MatSetOption(H, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
      PetscCall(add_elements(H, elements, Way::values));
      PetscFunctionReturn(PETSC_SUCCESS);
    });
    EXPECT_EQ(matrix.counts.elements, static_cast<PetscInt64>(elements.all.size()));
    matrix.add_negative(1);
    EXPECT_LT(difference(dense(matrix.H), elements.sum(1)), 1e-13);
  }
  ASSERT_EQ(ElementHook::detach(matrix.H), 0);
  ASSERT_EQ(MatZeroEntries(matrix.H), 0);
  ASSERT_EQ(add_elements(matrix.H, elements, Way::values), 0);
  EXPECT_LT(difference(dense(matrix.H), elements.sum(0)), 1e-13);
  ASSERT_EQ(MatDestroy(&other), 0);
}

}  // namespace
}  // namespace trefoil::test
