// The floor under filtered eigenvalues, against matrices of known eigenvalues.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "filter/filter.hpp"

namespace trefoil {
namespace {

/// Q diag(eigenvalues) Q' with a product of random reflections for Q, whose columns are kept.
struct Known {
  int n;
  std::vector<double> Q, H;

  Known(const std::vector<double> &eigenvalues, unsigned seed)
      : n(static_cast<int>(eigenvalues.size())) {
    const auto size = static_cast<std::size_t>(n);
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    Q.assign(size * size, 0);
    for (std::size_t i = 0; i < size; ++i) Q[i * size + i] = 1;
    for (int reflection = 0; reflection < n; ++reflection) {
      std::vector<double> v(size);
      double square = 0;
      for (double &x : v) {
        x = normal(engine);
        square += x * x;
      }
      for (std::size_t j = 0; j < size; ++j) {
        double product = 0;
        for (std::size_t i = 0; i < size; ++i) product += v[i] * Q[i * size + j];
        for (std::size_t i = 0; i < size; ++i) Q[i * size + j] -= 2 * product / square * v[i];
      }
    }
    H = with(eigenvalues);
  }
  [[nodiscard]] std::vector<double> with(const std::vector<double> &eigenvalues) const {
    const auto size = static_cast<std::size_t>(n);
    std::vector<double> A(size * size, 0);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j < size; ++j)
        for (std::size_t k = 0; k < size; ++k)
          A[i * size + j] += Q[i * size + k] * eigenvalues[k] * Q[j * size + k];
    return A;
  }
};

struct Wanted {
  double weight, share;
};

class FloorTest : public testing::TestWithParam<Wanted> {};

TEST_P(FloorTest, MovesEachEigenvalueWhereItIsSaid) {
  const auto [weight, share] = GetParam();
  // The gap to the zero eigenvalues, 0.03, enters the error: eigenvectors are known to eps 4 /
  // 0.03.
  const std::vector<double> eigenvalues{-3, -0.03, -0.7, 0, 0, 0, 0.03, 0.5, 2, 4};
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Known known(eigenvalues, seed);
    std::vector<double> N(known.H.size());
    int changed = -2, expected_changes = 0;
    const SplitResult result =
        split_with_floor(known.n, 1, known.H.data(), N.data(), &changed, {share, weight});
    ASSERT_EQ(result.status, SplitStatus::ok);
    std::vector<double> filtered;
    for (const double lambda : eigenvalues) {
      const double plain = lambda < 0 ? (2 * weight - 1) * -lambda : lambda;
      filtered.push_back(lambda == 0 ? 0 : std::max(plain, 4 * share));
      expected_changes += lambda < 0 || filtered.back() > lambda;
    }
    const std::vector<double> expected = known.with(filtered);
    for (std::size_t i = 0; i < N.size(); ++i) {
      EXPECT_NEAR(known.H[i] + 2 * weight * N[i], expected[i], 1e-13 * 4) << i;
    }
    EXPECT_EQ(changed, expected_changes);
    EXPECT_EQ(result.indefinite, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Weights, FloorTest,
                         testing::Values(Wanted{0.5, 1e-3}, Wanted{0.5, 0.3}, Wanted{1, 1e-3},
                                         Wanted{1, 0.3}, Wanted{0.75, 1e-2}, Wanted{0.125, 1e-2}));

TEST(NoFloorTest, IsPlainSplit) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Known known({-3, -1e-4, 0, 1, 2, 5}, seed);
    std::vector<double> N(36), plain(36);
    int count = 0, plain_count = 0;
    ASSERT_EQ(split_with_floor(6, 1, known.H.data(), N.data(), &count, {0, 0.5}).status,
              SplitStatus::ok);
    ASSERT_EQ(split(6, 1, known.H.data(), plain.data(), &plain_count).status, SplitStatus::ok);
    EXPECT_EQ(N, plain);
    EXPECT_EQ(count, plain_count);
  }
}

TEST(NoFloorTest, LeavesADefiniteMatrixAboveItAlone) {
  const Known known({1, 1.5, 2, 5}, 1);
  std::vector<double> N(16, 7);
  int count = -2;
  const SplitResult result = split_with_floor(4, 1, known.H.data(), N.data(), &count, {0.1, 1});
  EXPECT_EQ(result.indefinite, 0);
  EXPECT_EQ(count, 0);
  EXPECT_EQ(N, std::vector<double>(16, 0));
}

}  // namespace
}  // namespace trefoil
