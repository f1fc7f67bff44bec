// Rows in the order of their numbers, spread over the ranks, and back. Needs petsc_main.cpp.

#include "output/row_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "support/petsc_compatibility.hpp"

namespace trefoil::test {
namespace {

/// Rows that ranks hold at random; of row `number` component i is its value_of().
struct Rows {
  PetscMPIInt rank = 0, ranks = 1;
  std::vector<PetscInt> all, mine;

  /// @param stride between numbers: above 1 there are gaps
  Rows(PetscInt count, PetscInt stride) {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
    for (PetscInt k = 0; k < count; ++k) all.push_back(stride * k + stride / 2);
    std::mt19937 engine(7);
    std::shuffle(all.begin(), all.end(), engine);
    for (const PetscInt number : all) {
      if (static_cast<PetscMPIInt>(engine() % static_cast<unsigned>(ranks)) == rank) {
        mine.push_back(number);
      }
    }
    std::sort(all.begin(), all.end());
  }

  static double value_of(PetscInt number, int i) { return 10.0 * static_cast<double>(number) + i; }
  static std::vector<double> values_of(const std::vector<PetscInt> &numbers) {
    std::vector<double> values;
    for (const PetscInt number : numbers) {
      for (int i = 0; i < 3; ++i) values.push_back(value_of(number, i));
    }
    return values;
  }
};

class RowOrderTest : public testing::TestWithParam<PetscInt> {};  // stride between numbers

TEST_P(RowOrderTest, SharesAreInTheOrderOfTheNumbers) {
  const Rows rows(50, GetParam());
  RowOrder order;
  std::vector<double> share;
  ASSERT_EQ(order.set_up(PETSC_COMM_WORLD, rows.mine), PETSC_SUCCESS);
  EXPECT_EQ(order.total(), 50);
  ASSERT_EQ(order.arrange(Rows::values_of(rows.mine), 3, &share), PETSC_SUCCESS);
  const auto first = rows.all.begin() + order.first();
  EXPECT_EQ(share, Rows::values_of({first, first + order.share()}));
}

/// As a restart on another number of ranks does: any numbers, the same ones on several ranks, none.
TEST_P(RowOrderTest, FetchesRowsOfAnyRank) {
  const Rows rows(50, GetParam());
  RowOrder order;
  std::vector<double> share, fetched;
  ASSERT_EQ(order.set_up(PETSC_COMM_WORLD, rows.mine), PETSC_SUCCESS);
  const auto first = rows.all.begin() + order.first();
  share = Rows::values_of({first, first + order.share()});
  std::vector<PetscInt> backwards(rows.all.rbegin(), rows.all.rend()), some;
  for (std::size_t k = static_cast<std::size_t>(rows.rank); k < 50; k += 3) {
    some.push_back(rows.all[k]);
    some.push_back(rows.all[k]);
  }
  if (rows.rank == rows.ranks - 1) some.clear();
  for (const auto &wanted : {rows.mine, backwards, some}) {
    ASSERT_EQ(order.fetch(wanted, share, 3, &fetched), PETSC_SUCCESS);
    EXPECT_EQ(fetched, Rows::values_of(wanted));
  }
}

TEST_P(RowOrderTest, NumbersBecomePlaces) {
  const Rows rows(50, GetParam());
  RowOrder order;
  ASSERT_EQ(order.set_up(PETSC_COMM_WORLD, rows.mine), PETSC_SUCCESS);
  std::vector<PetscInt> places(rows.all);
  ASSERT_EQ(order.find_places(&places), PETSC_SUCCESS);
  for (std::size_t k = 0; k < places.size(); ++k) EXPECT_EQ(places[k], static_cast<PetscInt>(k));
}

INSTANTIATE_TEST_SUITE_P(Strides, RowOrderTest, testing::Values(1, 4));

TEST(RowNumbersTest, ATwiceGivenNumberIsRefusedOnAllRanks) {
  Rows rows(20, 1);
  if (std::find(rows.mine.begin(), rows.mine.end(), 3) != rows.mine.end()) rows.mine.push_back(3);
  ASSERT_EQ(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), PETSC_SUCCESS);
  RowOrder order;
  EXPECT_EQ(order.set_up(PETSC_COMM_WORLD, rows.mine), PETSC_ERR_ARG_SIZ);
  RowOrder negative;
  EXPECT_EQ(negative.set_up(PETSC_COMM_WORLD, {rows.rank == 0 ? -1 : rows.rank}),
            PETSC_ERR_ARG_SIZ);
  ASSERT_EQ(PetscPopErrorHandler(), PETSC_SUCCESS);
}

}  // namespace
}  // namespace trefoil::test
