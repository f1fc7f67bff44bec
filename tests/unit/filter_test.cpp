// The eigenvalue filter against an independent eigensolver: cyclic Jacobi in long double.
#include "filter/filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>
#include <iterator>
#include <latch>
#include <limits>
#include <ostream>
#include <random>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

namespace trefoil {
namespace {

using Matrix = std::vector<double>;  // n x n
using Wide = std::vector<long double>;

const double inf = std::numeric_limits<double>::infinity();
const double nan = std::numeric_limits<double>::quiet_NaN();

struct Eigenpairs {
  Wide values;   // ascending
  Wide vectors;  // eigenvector k is row k
};

/// Cyclic Jacobi: rotate away every off-diagonal entry in turn until none is left [Golub, Van
/// Loan].
Eigenpairs jacobi(int n, Wide A) {
  Wide V(A.size());
  for (int i = 0; i < n; ++i) V[i * n + i] = 1;
  for (int sweep = 0; sweep < 60; ++sweep) {
    long double off = 0, all = 0;
    for (int i = 0; i < n * n; ++i) {
      all += A[i] * A[i];
      if (i / n != i % n) off += A[i] * A[i];
    }
    if (off <= n * n * 1e-38L * all) break;
    for (int p = 0; p < n; ++p) {
      for (int q = p + 1; q < n; ++q) {
        if (A[p * n + q] == 0) continue;
        const long double cot = (A[q * n + q] - A[p * n + p]) / (2 * A[p * n + q]);
        const long double t = (cot < 0 ? -1 : 1) / (std::fabs(cot) + std::sqrt(1 + cot * cot));
        const long double c = 1 / std::sqrt(1 + t * t), s = c * t;
        const auto rotate = [c, s](long double &x, long double &y) {
          const long double old = x;
          x = c * old - s * y;
          y = s * old + c * y;
        };
        for (int i = 0; i < n; ++i) rotate(A[i * n + p], A[i * n + q]);
        for (int i = 0; i < n; ++i) rotate(A[p * n + i], A[q * n + i]);
        for (int i = 0; i < n; ++i) rotate(V[p * n + i], V[q * n + i]);
      }
    }
  }
  std::vector<int> order(n);
  for (int i = 0; i < n; ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](int i, int j) { return A[i * n + i] < A[j * n + j]; });
  Eigenpairs result;
  for (int k : order) {
    result.values.push_back(A[k * n + k]);
    result.vectors.insert(result.vectors.end(), &V[k * n], &V[k * n] + n);
  }
  return result;
}

/// sum_k f(lambda_k) v_k v_k'
Wide function_of(int n, const Eigenpairs &eigen, const std::function<long double(long double)> &f) {
  Wide result(n * n);
  for (int k = 0; k < n; ++k) {
    const long double f_k = f(eigen.values[k]);
    if (f_k == 0) continue;
    const long double *v = &eigen.vectors[k * n];
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) result[i * n + j] += f_k * v[i] * v[j];
    }
  }
  return result;
}

long double spectral_norm(const Eigenpairs &eigen) {
  return std::max(std::fabs(eigen.values.front()), std::fabs(eigen.values.back()));
}

/// Frobenius norm of A - B: never less than the spectral norm that the contract is written in.
template <class A, class B>
long double distance(const A &a, const B &b) {
  long double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const long double difference = static_cast<long double>(a[i]) - b[i];
    sum += difference * difference;
  }
  return std::sqrt(sum);
}

Wide widen(const Matrix &A) {
  return {A.begin(), A.end()};
}

Matrix rows_of_noise(int rows, int n, std::mt19937 &random) {
  std::normal_distribution<double> normal;
  Matrix B(rows * n);
  for (double &b : B) b = normal(random);
  return B;
}

/// sum_k weight_k b_k b_k' over the rows of B: symmetric exactly, of rank <= rows.
Matrix weighted_squares(int n, const Matrix &B, const std::vector<double> &weight) {
  Matrix H(n * n);
  for (std::size_t k = 0; k < weight.size(); ++k) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) H[i * n + j] += weight[k] * (B[k * n + i] * B[k * n + j]);
    }
  }
  return H;
}

/// Q diag(spectrum) Q' with a random orthogonal Q.
Matrix with_spectrum(const std::vector<double> &spectrum, std::mt19937 &random) {
  const int n = static_cast<int>(spectrum.size());
  Matrix Q = rows_of_noise(n, n, random);
  for (int k = 0; k < n; ++k) {
    for (int l = 0; l < 2 * k; ++l) {  // Gram-Schmidt, twice
      double dot = 0, *q = &Q[k * n], *p = &Q[(l % k) * n];
      for (int i = 0; i < n; ++i) dot += q[i] * p[i];
      for (int i = 0; i < n; ++i) q[i] -= dot * p[i];
    }
    double square = 0;
    for (int i = 0; i < n; ++i) square += Q[k * n + i] * Q[k * n + i];
    for (int i = 0; i < n; ++i) Q[k * n + i] /= std::sqrt(square);
  }
  return weighted_squares(n, Q, spectrum);
}

Matrix diagonal(const std::vector<double> &entries) {
  const int n = static_cast<int>(entries.size());
  Matrix H(n * n);
  for (int i = 0; i < n; ++i) H[i * n + i] = entries[i];
  return H;
}

/// Like the Hessian of a 3D element: translations of all nodes cost no energy.
Matrix element_like(int n, int negatives, std::mt19937 &random) {
  const int rank = std::max(1, n - 3), dim = n % 3 == 0 ? 3 : 1, nodes = n / dim;
  Matrix B = rows_of_noise(rank, n, random);
  for (int k = 0; k < rank; ++k) {
    for (int c = 0; c < dim; ++c) {
      double mean = 0;
      for (int a = 0; a < nodes; ++a) mean += B[k * n + a * dim + c] / nodes;
      for (int a = 0; a < nodes; ++a) B[k * n + a * dim + c] -= mean;
    }
  }
  std::vector<double> weight(rank);
  for (int k = 0; k < rank; ++k) weight[k] = (k < negatives ? -1 : 1) * std::pow(10.0, k % 4 - 1);
  return weighted_squares(n, B, weight);
}

std::vector<double> spectrum(int n, const std::function<double(int)> &value) {
  std::vector<double> values(n);
  for (int k = 0; k < n; ++k) values[k] = value(k);
  return values;
}

Matrix random_symmetric(int n, std::mt19937 &random) {
  const Matrix B = rows_of_noise(n, n, random);
  Matrix H(n * n);
  for (int i = 0; i < n * n; ++i) H[i] = B[i] + B[i % n * n + i / n];
  return H;
}

struct Kind {
  const char *name;
  Matrix (*make)(int n, std::mt19937 &random);

  friend void PrintTo(const Kind &kind, std::ostream *out) { *out << kind.name; }
};

const Kind kinds[] = {
    {"random", random_symmetric},
    {"definite",
     [](int n, std::mt19937 &r) {
       return with_spectrum(spectrum(n, [](int k) { return 1.0 + k; }), r);
     }},
    {"rank_deficient",
     [](int n, std::mt19937 &r) {
       const int rank = (n + 1) / 2;
       return weighted_squares(n, rows_of_noise(rank, n, r), std::vector<double>(rank, 1.0));
     }},
    {"negative_definite",
     [](int n, std::mt19937 &r) {
       return with_spectrum(spectrum(n, [](int k) { return -1.0 - k; }), r);
     }},
    {"zero", [](int n, std::mt19937 &) { return Matrix(n * n); }},
    {"diagonal",
     [](int n, std::mt19937 &) {
       return diagonal(spectrum(n, [](int k) { return 0.5 + k - k % 3 * 1.5 * k; }));
     }},
    {"repeated",
     [](int n, std::mt19937 &r) {
       return with_spectrum(spectrum(n, [n](int k) { return 2 * k < n ? -3.0 : 2.0; }), r);
     }},
    {"graded",
     [](int n, std::mt19937 &r) {
       return with_spectrum(
           spectrum(n, [](int k) { return (k % 2 ? -1 : 1) * std::pow(10.0, -(k % 17)); }), r);
     }},
    {"graded_by_rows",
     [](int n, std::mt19937 &r) {
       Matrix H = random_symmetric(n, r);
       for (int i = 0; i < n * n; ++i) H[i] *= std::pow(10.0, -(i / n + i % n) % 15);
       return H;
     }},
    {"barely_negative",
     [](int n, std::mt19937 &r) {
       return with_spectrum(
           spectrum(n, [n](int k) { return k == 0 ? -n * DBL_EPSILON * 4 : double(k); }), r);
     }},
    {"definite_element", [](int n, std::mt19937 &r) { return element_like(n, 0, r); }},
    {"indefinite_element", [](int n, std::mt19937 &r) { return element_like(n, 1 + n / 3, r); }},
};

/// split() of one matrix that must be fine.
Matrix negative_part(int n, const Matrix &H, int *count = nullptr) {
  Matrix N(n * n, nan);
  int negative = -2;
  const SplitResult result = split(n, 1, H.data(), N.data(), &negative);
  EXPECT_EQ(result.status, SplitStatus::ok);
  EXPECT_EQ(result.first_bad, -1);
  EXPECT_EQ(result.indefinite, negative > 0);
  if (count) *count = negative;
  return N;
}

/// H + N has the eigenvalues max(lambda, 0) and H + 2 N has |lambda|.
void expect_filtered_spectra(int n, const Matrix &H, const Matrix &N, const Wide &lambda,
                             long double tolerance) {
  Wide clamped = widen(H), absolute = widen(H), expected_clamped, expected_absolute;
  for (int i = 0; i < n * n; ++i) {
    clamped[i] += N[i];
    absolute[i] += 2 * static_cast<long double>(N[i]);
  }
  for (long double value : lambda) {
    expected_clamped.push_back(std::max(value, 0.0L));
    expected_absolute.push_back(std::fabs(value));
  }
  std::sort(expected_absolute.begin(), expected_absolute.end());
  clamped = jacobi(n, clamped).values;
  absolute = jacobi(n, absolute).values;
  for (int k = 0; k < n; ++k) {
    EXPECT_LE(std::fabs(clamped[k] - expected_clamped[k]), tolerance);
    EXPECT_LE(std::fabs(absolute[k] - expected_absolute[k]), 2 * tolerance);
  }
}

/// N H = H N
void expect_commute(int n, const Matrix &H, const Matrix &N, long double tolerance) {
  Wide commutator(n * n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        commutator[i * n + j] += static_cast<long double>(N[i * n + k]) * H[k * n + j] -
                                 static_cast<long double>(H[i * n + k]) * N[k * n + j];
      }
    }
  }
  EXPECT_LE(distance(commutator, Wide(n * n)), tolerance);
}

class Filter : public testing::TestWithParam<std::tuple<Kind, int>> {};

TEST_P(Filter, AgreesWithJacobi) {
  const auto [kind, n] = GetParam();
  for (unsigned seed = 1; seed <= (n <= 30 ? 10 : 1); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const Matrix H = kind.make(n, random);
    const Eigenpairs exact = jacobi(n, widen(H));
    const long double norm = spectral_norm(exact), tolerance = split_accuracy(n) * norm;
    int count = 0;
    const Matrix N = negative_part(n, H, &count);

    // The oracle is one: Q D Q' = H.
    ASSERT_LE(distance(function_of(n, exact, [](auto x) { return x; }), H), tolerance / 100);
    EXPECT_LE(distance(N, function_of(n, exact, [](auto x) { return x < 0 ? -x : 0; })), tolerance);

    for (int i = 0; i < n * n; ++i) {
      ASSERT_EQ(N[i], N[i % n * n + i / n]) << "not symmetric at " << i / n << ", " << i % n;
    }
    if (n <= 60) {  // the oracle takes its time
      expect_filtered_spectra(n, H, N, exact.values, tolerance);
      expect_commute(n, H, N, 2 * tolerance * norm);
    }

    // Around the threshold itself the count may fall either way.
    const long double threshold = n * DBL_EPSILON * norm;
    const auto below = [&](long double limit) {
      return std::count_if(exact.values.begin(), exact.values.end(),
                           [limit](long double value) { return value < limit; });
    };
    EXPECT_GE(count, below(-3 * threshold));
    EXPECT_LE(count, below(-threshold / 10));
    if (count == 0) {
      EXPECT_EQ(N, Matrix(n * n));
    }
    if (is_positive_semidefinite(n, H.data())) {
      EXPECT_EQ(count, 0);
      EXPECT_GE(exact.values[0], -tolerance);
    }
  }
}

std::string name_of(const testing::TestParamInfo<Filter::ParamType> &info) {
  return std::string(std::get<Kind>(info.param).name) + "_" +
         std::to_string(std::get<int>(info.param));
}
INSTANTIATE_TEST_SUITE_P(Small, Filter,
                         testing::Combine(testing::ValuesIn(kinds),
                                          testing::Values(1, 2, 3, 6, 9, 12, 24, 30, 60)),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Large, Filter,
                         testing::Combine(testing::Values(kinds[0], kinds[2], kinds[6]),
                                          testing::Values(192)),
                         name_of);

TEST(FilterByHand, KnownNegativeParts) {
  EXPECT_EQ(negative_part(1, {-3}), Matrix{3});
  EXPECT_EQ(negative_part(1, {3}), Matrix{0});
  const Matrix N = negative_part(2, {0, 1, 1, 0});  // eigenvalue -1 along (1, -1)/sqrt 2
  EXPECT_NEAR(N[0], 0.5, 1e-15);
  EXPECT_NEAR(N[1], -0.5, 1e-15);
  EXPECT_NEAR(N[3], 0.5, 1e-15);
}

TEST(FilterByHand, ThresholdSeparatesNoiseFromIndefiniteness) {
  for (int n : {2, 3, 9, 12, 24, 30, 60}) {
    for (double largest : {1.0, -1.0}) {
      for (double factor : {0.5, 0.9, 1.1, 2.0, 100.0}) {
        std::vector<double> entries(n, 1.0);
        entries[0] = largest;
        entries[n - 1] = -factor * n * DBL_EPSILON;
        int count = 0;
        const Matrix N = negative_part(n, diagonal(entries), &count);
        EXPECT_EQ(count, (largest < 0) + (factor > 1)) << n << ' ' << factor;
        EXPECT_EQ(N[n * n - 1], factor > 1 ? -entries[n - 1] : 0.0) << n << ' ' << factor;
      }
    }
  }
}

TEST(FilterByHand, OnlyTheSymmetricPartMatters) {
  const Matrix N = negative_part(2, {1, 5, -1, -4});
  EXPECT_EQ(N, negative_part(2, {1, -1, 5, -4}));
  EXPECT_EQ(N, negative_part(2, {1, 2, 2, -4}));
  EXPECT_EQ(negative_part(2, {0, 7, -7, 0}), Matrix(4));
}

class Semidefinite : public testing::TestWithParam<int> {};

TEST_P(Semidefinite, NeverMissesAnEigenvalueBelowTheContract) {
  const int n = GetParam();
  std::mt19937 random(7);
  for (int step = 0; step < 40; ++step) {
    const double smallest = -std::pow(10.0, -17 + 0.15 * step);  // -1e-17 .. -7e-12
    for (double others : {1.0, 1e-2, 0.0}) {
      auto values = spectrum(n, [=](int k) { return k == 0 ? 1.0 : others; });
      values[n - 1] = smallest;
      const Matrix H = with_spectrum(values, random);
      if (is_positive_semidefinite(n, H.data())) {
        EXPECT_GE(jacobi(n, widen(H)).values[0], -split_accuracy(n)) << smallest << ' ' << others;
      }
      if (smallest < -2 * split_accuracy(n)) {
        EXPECT_FALSE(is_positive_semidefinite(n, H.data()));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, Semidefinite, testing::Values(2, 3, 6, 9, 12, 24, 30, 60));

TEST(SemidefiniteBorder, AcceptsDefiniteAndZero) {
  std::mt19937 random(7);
  for (int n : {1, 2, 3, 12, 30, 60, largest_element_matrix}) {
    EXPECT_TRUE(is_positive_semidefinite(n, Matrix(n * n).data())) << n;
    EXPECT_TRUE(is_positive_semidefinite(n, diagonal(std::vector<double>(n, 1.0)).data())) << n;
    EXPECT_FALSE(is_positive_semidefinite(n, diagonal(std::vector<double>(n, -1.0)).data())) << n;
    for (double scale : {1e-300, 1.0, 1e300}) {
      const auto values = spectrum(n, [scale](int k) { return scale * (1 + k % 5); });
      EXPECT_TRUE(is_positive_semidefinite(n, with_spectrum(values, random).data())) << n;
    }
  }
}

TEST(SemidefiniteBorder, LiesAtTheThresholdOfSplit) {
  for (int n : {2, 3, 6, 12, 24, 30, 60}) {
    for (double scale : {1e-300, 1.0, 1e300}) {
      std::vector<double> entries(n);
      entries[0] = scale;
      EXPECT_TRUE(is_positive_semidefinite(n, diagonal(entries).data())) << n;
      entries[n - 1] = -0.9 * n * DBL_EPSILON * scale;
      EXPECT_TRUE(is_positive_semidefinite(n, diagonal(entries).data())) << n;
      entries[n - 1] = -1.1 * n * DBL_EPSILON * scale;
      EXPECT_FALSE(is_positive_semidefinite(n, diagonal(entries).data())) << n;
    }
  }
}

TEST(SemidefiniteBorder, TranslationsPassTheCheapTest) {
  std::mt19937 random(3);
  int proven = 0;
  for (int i = 0; i < 1000; ++i) {
    proven += is_positive_semidefinite(12, element_like(12, 0, random).data());
  }
  EXPECT_GE(proven, 950);  // a few may fall to the eigenvalues; all would be a lost early out
}

TEST(SemidefiniteBorder, RejectsNonFiniteAndBadSizes) {
  EXPECT_FALSE(is_positive_semidefinite(2, Matrix{1, 0, 0, nan}.data()));
  EXPECT_FALSE(is_positive_semidefinite(2, Matrix{1, 0, 0, inf}.data()));
  EXPECT_FALSE(is_positive_semidefinite(0, nullptr));
  EXPECT_FALSE(is_positive_semidefinite(largest_element_matrix + 1, nullptr));
}

TEST(FilterScale, PowersOfTwoScaleExactly) {
  for (int n : {1, 3, 12, 30}) {
    std::mt19937 random(5);
    const Matrix H = random_symmetric(n, random);
    int count = 0;
    const Matrix N = negative_part(n, H, &count);
    for (int exponent : {-960, -511, -333, -1, 1, 64, 500, 777, 1000}) {
      Matrix scaled = H, expected = N;
      for (double &h : scaled) h = std::ldexp(h, exponent);
      for (double &h : expected) h = std::ldexp(h, exponent);
      int count_scaled = 0;
      EXPECT_EQ(negative_part(n, scaled, &count_scaled), expected) << n << ' ' << exponent;
      EXPECT_EQ(count_scaled, count);
    }
  }
}

TEST(FilterScale, FromSubnormalToTheLargestDoubles) {
  const int n = 12;
  for (double scale : {1e-323, 1e-320, 1e-310, 1e-300, 1e-150, 1e150, 1e300, 1e307}) {
    std::mt19937 random(5);
    Matrix H = random_symmetric(n, random);
    for (double &h : H) h *= scale;
    const Eigenpairs exact = jacobi(n, widen(H));
    const Wide expected = function_of(n, exact, [](auto x) { return x < 0 ? -x : 0; });
    // Below the normal range a number has no better accuracy than the smallest subnormal.
    const long double tolerance =
        1e-13L * spectral_norm(exact) + n * static_cast<long double>(DBL_TRUE_MIN);
    EXPECT_LE(distance(negative_part(n, H), expected), tolerance) << scale;
  }
  EXPECT_EQ(negative_part(1, {-DBL_TRUE_MIN}), Matrix{DBL_TRUE_MIN});
  EXPECT_EQ(negative_part(1, {-DBL_MAX}), Matrix{DBL_MAX});
}

/// Elements of all sorts, one after the other.
Matrix mixed_batch(int n, int batch) {
  std::mt19937 random(11);
  Matrix H;
  for (int b = 0; b < batch; ++b) {
    const Matrix one = kinds[b % std::size(kinds)].make(n, random);
    H.insert(H.end(), one.begin(), one.end());
  }
  return H;
}

TEST(FilterBatch, EqualsOneByOne) {
  const int batch = 50;
  for (int n : {30, 1, 3, 12, 24}) {
    const Matrix H = mixed_batch(n, batch);
    Matrix N(H.size(), nan);
    std::vector<int> negative(batch, -2);
    const SplitResult result = split(n, batch, H.data(), N.data(), negative.data());
    EXPECT_EQ(result.status, SplitStatus::ok);
    long indefinite = 0;
    for (int b = 0; b < batch; ++b) {
      int count = 0;
      const Matrix one(&H[b * n * n], &H[b * n * n] + n * n);
      EXPECT_EQ(Matrix(&N[b * n * n], &N[b * n * n] + n * n), negative_part(n, one, &count));
      EXPECT_EQ(negative[b], count);
      indefinite += count > 0;
    }
    EXPECT_EQ(result.indefinite, indefinite);
    EXPECT_GT(indefinite, 0);
    EXPECT_LT(indefinite, batch);

    Matrix without_counts(H.size(), nan);
    EXPECT_EQ(split(n, batch, H.data(), without_counts.data(), nullptr).indefinite, indefinite);
    EXPECT_EQ(without_counts, N);
  }
}

TEST(FilterBatch, EmptyBatchTouchesNothing) {
  const SplitResult result = split(12, 0, nullptr, nullptr, nullptr);
  EXPECT_EQ(result.status, SplitStatus::ok);
  EXPECT_EQ(result.first_bad, -1);
  EXPECT_EQ(result.indefinite, 0);
}

TEST(FilterBatch, BadSizesAreRefused) {
  for (auto [n, batch] : {std::pair{0, 1}, {-1, 1}, {largest_element_matrix + 1, 1}, {3, -1}}) {
    double N = 5;
    EXPECT_EQ(split(n, batch, &N, &N, nullptr).status, SplitStatus::bad_size);
    EXPECT_EQ(N, 5);
  }
}

TEST(FilterBatch, NonFiniteMatrixIsReportedAndNeighboursAreRight) {
  const int n = 3, batch = 12, size = n * n;
  const Matrix good = mixed_batch(n, batch);
  Matrix N_good(good.size());
  std::vector<int> negative_good(batch), negative(batch);
  ASSERT_EQ(split(n, batch, good.data(), N_good.data(), negative_good.data()).first_bad, -1);
  for (double poison : {nan, inf, -inf}) {
    for (int at = 0; at < batch * size; ++at) {
      const int bad = at / size;
      Matrix H = good, N(good.size());
      H[at] = poison;
      H.back() = poison;  // a second one: the first is the one named
      const SplitResult result = split(n, batch, H.data(), N.data(), negative.data());
      ASSERT_EQ(result.status, SplitStatus::not_finite);
      ASSERT_EQ(result.first_bad, bad);
      for (int i = 0; i < batch * size; ++i) {
        if (i / size == bad || i / size == batch - 1) {
          ASSERT_TRUE(std::isnan(N[i])) << at << ' ' << i;
        } else {
          ASSERT_EQ(N[i], N_good[i]) << at << ' ' << i;
        }
      }
      long indefinite = 0;
      for (int b = 0; b < batch; ++b) {
        ASSERT_EQ(negative[b], b == bad || b == batch - 1 ? -1 : negative_good[b]);
        indefinite += negative[b] > 0;
      }
      ASSERT_EQ(result.indefinite, indefinite);
    }
  }
}

TEST(FilterThreads, TwoThreadsGetTheSameAnswer) {
  const int n = 12, batch = 5000;  // long enough for the two to meet
  const Matrix H = mixed_batch(n, batch);
  Matrix alone(H.size()), first(H.size()), second(H.size());
  const auto run = [&](Matrix &N) { (void)split(n, batch, H.data(), N.data(), nullptr); };
  run(alone);
  std::latch start(2);
  const auto run_together = [&](Matrix &N) {
    start.arrive_and_wait();
    run(N);
  };
  std::thread one([&] { run_together(first); }), two([&] { run_together(second); });
  one.join();
  two.join();
  EXPECT_EQ(first, alone);
  EXPECT_EQ(second, alone);
}

}  // namespace
}  // namespace trefoil
