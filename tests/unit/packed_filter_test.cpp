// split_packed() against split(), for every size and instruction set: matrices with the spectra of
// elements (few large eigenvalues, clusters, null spaces) and extreme ones.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "filter/packed_filter.hpp"

namespace trefoil {
namespace {

using Case = std::tuple<int, InstructionSet>;

class PackedFilterTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    if (!processor_has(std::get<1>(GetParam()))) GTEST_SKIP() << "not on this processor";
  }
  const int n_ = std::get<0>(GetParam());
  const std::size_t rows_ = static_cast<std::size_t>(n_), entries_ = rows_ * (rows_ + 1) / 2;

  /// A matrix with the given eigenvalues in a random basis.
  template <class Random>
  std::vector<double> matrix(Random &random, const std::vector<double> &eigenvalues) const {
    std::normal_distribution<double> normal;
    std::vector<double> Q(rows_ * rows_), A(rows_ * rows_, 0);
    for (double &q : Q) q = normal(random);
    for (std::size_t k = 0; k < rows_; ++k) {  // Gram-Schmidt, twice
      double *v = &Q[rows_ * k];
      for (int again = 0; again < 2; ++again)
        for (std::size_t l = 0; l < k; ++l) {
          double dot = 0;
          for (std::size_t i = 0; i < rows_; ++i) dot += Q[rows_ * l + i] * v[i];
          for (std::size_t i = 0; i < rows_; ++i) v[i] -= dot * Q[rows_ * l + i];
        }
      double square = 0;
      for (std::size_t i = 0; i < rows_; ++i) square += v[i] * v[i];
      for (std::size_t i = 0; i < rows_; ++i) v[i] /= std::sqrt(square);
    }
    for (std::size_t k = 0; k < rows_; ++k)
      for (std::size_t i = 0; i < rows_; ++i)
        for (std::size_t j = 0; j <= i; ++j)
          A[rows_ * i + j] += eigenvalues[k] * Q[rows_ * k + i] * Q[rows_ * k + j];
    for (std::size_t i = 0; i < rows_; ++i)
      for (std::size_t j = 0; j < i; ++j) A[rows_ * j + i] = A[rows_ * i + j];
    return A;
  }

  /// Compares N and counts with those of split(); returns how many matrices fell back to it.
  long check(const std::vector<std::vector<double>> &matrices, bool same_counts = true) const {
    const std::size_t packs = (matrices.size() + 7) / 8;
    std::vector<double> K(packs * entries_ * 8, 0), N(K.size(), 7);
    std::vector<int> negative(packs * 8, 7);
    const auto place = [&](std::size_t m, std::size_t i, std::size_t j) {
      return (m / 8 * entries_ + i * (i + 1) / 2 + j) * 8 + m % 8;
    };
    for (std::size_t m = 0; m < matrices.size(); ++m)
      for (std::size_t i = 0; i < rows_; ++i)
        for (std::size_t j = 0; j <= i; ++j) K[place(m, i, j)] = matrices[m][rows_ * i + j];
    ReducedSplitExperiment experiment{std::get<1>(GetParam())};
    const SplitResult result =
        split_packed(n_, static_cast<int>(packs), K.data(), N.data(), negative.data(), experiment);
    EXPECT_EQ(result.status, SplitStatus::ok);
    long indefinite = 0;
    for (std::size_t m = 0; m < matrices.size(); ++m) {
      std::vector<double> expected(rows_ * rows_);
      int count = 0;
      EXPECT_EQ(split(n_, 1, matrices[m].data(), expected.data(), &count).status, SplitStatus::ok);
      if (same_counts) {
        EXPECT_EQ(negative[m], count) << m;
      }
      indefinite += negative[m] > 0;
      double size = 0, error = 0;
      for (std::size_t i = 0; i < rows_; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
          size = std::max(size, std::abs(matrices[m][rows_ * i + j]));
          error = std::max(error, std::abs(N[place(m, i, j)] - expected[rows_ * i + j]));
        }
      // Entries are below the norm; both sides may be off by the contract.
      EXPECT_LE(error, 2 * split_accuracy(n_) * size * n_) << m;
      if (negative[m] == 0) {
        for (std::size_t e = 0; e < entries_; ++e)
          EXPECT_EQ(N[(m / 8 * entries_ + e) * 8 + m % 8], 0);
      }
    }
    EXPECT_EQ(result.indefinite, indefinite);
    return experiment.fallbacks;
  }
};

TEST_P(PackedFilterTest, EqualsSplitOnElementLikeSpectra) {
  std::mt19937 random(static_cast<unsigned>(n_));
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<std::vector<double>> matrices;
  for (int m = 0; m < 403; ++m) {
    std::vector<double> eigenvalues(rows_);
    const double stiff = std::pow(10., 7 * uniform(random)), share = 0.6 * uniform(random);
    for (std::size_t k = 0; k < rows_; ++k) {
      eigenvalues[k] = 0.2 + uniform(random);
      if (k * 7 < rows_) eigenvalues[k] = stiff;                        // volume
      if (uniform(random) < share) eigenvalues[k] *= -uniform(random);  // indefinite
    }
    matrices.push_back(matrix(random, eigenvalues));
  }
  EXPECT_LE(check(matrices), 20);  // one in twenty may be sent to LAPACK
}

TEST_P(PackedFilterTest, EqualsSplitOnClustersAndNullSpaces) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<std::vector<double>> matrices;
  for (int m = 0; m < 160; ++m) {
    std::vector<double> eigenvalues(rows_, 1);
    for (std::size_t k = 0; k < rows_; ++k) {
      if (m % 4 == 0 && k % 2 == 0) eigenvalues[k] = -0.5;                    // all the same
      if (m % 4 == 1) eigenvalues[k] = k % 3 == 0 ? 0 : k % 3 == 1 ? -1 : 1;  // null space
      if (m % 4 == 2) eigenvalues[k] = -1 - 1e-9 * uniform(random);           // negative definite
      if (m % 4 == 3) eigenvalues[k] = k % 2 ? 1 : -std::pow(10., -12 * uniform(random));
    }
    matrices.push_back(matrix(random, eigenvalues));
  }
  check(matrices, false);  // what counts as zero may differ where eigenvalues are 1e-14
}

TEST_P(PackedFilterTest, DiagonalZeroAndScaledMatrices) {
  std::mt19937 random(11);
  std::vector<std::vector<double>> matrices;
  matrices.emplace_back(rows_ * rows_, 0);
  std::vector<double> diagonal(rows_ * rows_, 0);
  for (std::size_t i = 0; i < rows_; ++i) diagonal[(rows_ + 1) * i] = i % 2 ? 1. : -2.;
  matrices.push_back(diagonal);
  std::vector<double> eigenvalues(rows_, 1);
  eigenvalues[0] = -3;
  eigenvalues[1] = -1e-3;
  const std::vector<double> A = matrix(random, eigenvalues);
  for (const double scale : {1e-300, 1e-150, 1e-30, 1., 1e30, 1e150, 1e300}) {
    matrices.push_back(A);
    for (double &entry : matrices.back()) entry *= scale;
  }
  check(matrices);
}

TEST_P(PackedFilterTest, NotANumberStaysWithItsMatrix) {
  std::mt19937 random(13);
  std::vector<double> K(entries_ * 8, 0), N(K.size());
  for (std::size_t lane = 0; lane < 8; ++lane)
    for (std::size_t i = 0; i < rows_; ++i) K[(i * (i + 1) / 2 + i) * 8 + lane] = -1;
  K[3] = std::numeric_limits<double>::quiet_NaN();
  int negative[8];
  ReducedSplitExperiment experiment{std::get<1>(GetParam())};
  const SplitResult result = split_packed(n_, 1, K.data(), N.data(), negative, experiment);
  EXPECT_EQ(result.status, SplitStatus::not_finite);
  EXPECT_EQ(result.first_bad, 3);
  for (std::size_t lane = 0; lane < 8; ++lane) {
    EXPECT_EQ(negative[lane], lane == 3 ? -1 : n_);
    EXPECT_EQ(std::isnan(N[lane]), lane == 3);
    if (lane != 3) {
      EXPECT_NEAR(N[lane], 1, 1e-14);
    }
  }
}

TEST_P(PackedFilterTest, TheFirstBadMatrixIsCountedFromTheBeginning) {
  // Long batches are split in stretches.
  constexpr std::size_t packs = 150, bad = 1003, worse = 1101;
  std::vector<double> K(packs * entries_ * 8, 0), N(K.size());
  std::vector<int> negative(packs * 8);
  for (std::size_t m = 0; m < packs * 8; ++m)
    for (std::size_t i = 0; i < rows_; ++i)
      K[(m / 8 * entries_ + i * (i + 1) / 2 + i) * 8 + m % 8] =
          m == bad || m == worse ? std::numeric_limits<double>::infinity() : 1;
  ReducedSplitExperiment experiment{std::get<1>(GetParam())};
  const SplitResult result =
      split_packed(n_, packs, K.data(), N.data(), negative.data(), experiment);
  EXPECT_EQ(result.status, SplitStatus::not_finite);
  EXPECT_EQ(result.first_bad, static_cast<int>(bad));
  EXPECT_EQ(result.indefinite, 0);
  for (std::size_t m = 0; m < packs * 8; ++m)
    EXPECT_EQ(negative[m], m == bad || m == worse ? -1 : 0) << m;
}

TEST(PackedFilter, OtherSizesAreRefused) {
  double K[8] = {}, N[8];
  int negative[8];
  EXPECT_EQ(split_packed(1, 1, K, N, negative).status, SplitStatus::bad_size);
}

std::string name_of(const testing::TestParamInfo<Case> &each) {
  const char *sets[] = {"baseline", "avx2", "avx512"};
  return std::to_string(std::get<0>(each.param)) + "_" +
         sets[static_cast<int>(std::get<1>(each.param))];
}

INSTANTIATE_TEST_SUITE_P(Sizes, PackedFilterTest,
                         testing::Combine(testing::Values(4, 9, 10, 27),
                                          testing::Values(InstructionSet::baseline,
                                                          InstructionSet::avx2,
                                                          InstructionSet::avx512)),
                         name_of);

}  // namespace
}  // namespace trefoil
