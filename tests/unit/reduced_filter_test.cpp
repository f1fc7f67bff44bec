// The filter in SIMD lanes against the plain one, which has its own test against an independent
// eigensolver. By every instruction set that this processor has.
#include "filter/reduced_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numeric>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

#include "reduced_matrices.hpp"

namespace trefoil {
namespace {

using namespace reduced_matrices;

// 100: more than a million matrices, 20 s. Less for sanitizers.
#ifndef TREFOIL_REDUCED_TEST_PERCENT
#define TREFOIL_REDUCED_TEST_PERCENT 40
#endif

const double inf = std::numeric_limits<double>::infinity();
const double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<InstructionSet> instruction_sets() {
  std::vector<InstructionSet> result;
  for (auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
    if (processor_has(set)) result.push_back(set);
  }
  return result;
}

const char *name_of(InstructionSet set) {
  return set == InstructionSet::avx512 ? "avx512"
         : set == InstructionSet::avx2 ? "avx2"
                                       : "baseline";
}

// ---- Matrices -----------------------------------------------------------------------------------

Matrix diagonal(const std::function<double(int)> &value) {
  Matrix A{};
  for (int i = 0; i < n; ++i) A[n * i + i] = value(i);
  return A;
}

/// A random orthogonal matrix, its vectors in rows [Gram-Schmidt, twice].
Matrix orthogonal(Random &random) {
  Matrix Q;
  for (double &q : Q) q = normal(random);
  for (int k = 0; k < n; ++k) {
    double *q = &Q[n * k];
    for (int l = 0; l < 2 * k; ++l) {
      const double *p = &Q[n * (l % k)], dot = std::inner_product(q, q + n, p, 0.0);
      for (int i = 0; i < n; ++i) q[i] -= dot * p[i];
    }
    const double length = std::sqrt(std::inner_product(q, q + n, q, 0.0));
    for (int i = 0; i < n; ++i) q[i] /= length;
  }
  return Q;
}

Matrix with_spectrum(Random &random, const std::function<double(int)> &value) {
  const Matrix Q = orthogonal(random);
  Matrix A{};
  for (int k = 0; k < n; ++k) {
    const double lambda = value(k);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) A[n * i + j] += lambda * (Q[n * k + i] * Q[n * k + j]);
    }
  }
  return A;
}

Matrix random_symmetric(Random &random) {
  Matrix A;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) A[n * i + j] = A[n * j + i] = normal(random);
  }
  return A;
}

/// Keeps the entries (i, j), i >= j, for which `keep` holds.
Matrix sparse(Random &random, const std::function<bool(int, int)> &keep) {
  Matrix A = random_symmetric(random);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) {
      if (!keep(i, j)) A[n * i + j] = A[n * j + i] = 0;
    }
  }
  return A;
}

int pick(Random &random, int choices) {
  return std::uniform_int_distribution<int>(0, choices - 1)(random);
}

double some_poisson(Random &random) {
  const double poisson[] = {0.3, 0.495, 0.4999};
  return poisson[pick(random, 3)];
}

/// Any deformation gradient, so also inverted ones.
Matrix crushed_element(Random &random) {
  Matrix3 F;
  for (auto &row : F) {
    for (double &x : row) x = normal(random);
  }
  return element(tetrahedron(random, 0.3, 1), F, some_poisson(random));
}

/// Deformed flat, to a needle or to a point, or turned inside out.
Matrix collapsed_element(Random &random) {
  const double small = std::pow(10.0, uniform(random, -12, -1)), sign = pick(random, 2) ? 1 : -1;
  const Vector3 stretches[] = {{1.2, 0.9, sign * small},
                               {1.1, small, small},
                               {small, small, small},
                               {-1, 1, 1},
                               {1.5, 0.7, -0.8}};
  return element(tetrahedron(random, 0.1, 1), deformation(random, stretches[pick(random, 5)]),
                 some_poisson(random));
}

/// Slivers and needles.
Matrix badly_shaped_element(Random &random) {
  const double squeeze = std::pow(10.0, uniform(random, -5, 0));
  const double a = uniform(random, 0.5, 2), b = uniform(random, 0.5, 2);
  return element(tetrahedron(random, 0.4, squeeze), deformation(random, {a, b, 1 / (a * b)}),
                 some_poisson(random));
}

/// Close to rest, or turned: hardly anything is negative.
Matrix calm_element(Random &random) {
  const double size = pick(random, 4) == 0 ? 0 : std::pow(10.0, uniform(random, -14, -2));
  const auto stretch = [&] { return 1 + size * normal(random); };
  return element(tetrahedron(random, 0.1, 1),
                 deformation(random, {stretch(), stretch(), stretch()}), some_poisson(random));
}

/// A regular tetrahedron or a corner of a cube, stretched along the axes: repeated eigenvalues.
Matrix regular_element(Random &random) {
  const double stretches[] = {0.4, 0.7, 1, 1.3, -0.5};
  const auto stretch = [&] { return stretches[pick(random, 5)]; };
  Matrix3 edges{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  if (pick(random, 2)) edges = {{{1, 1, 0}, {0, 1, 1}, {1, 0, 1}}};
  const Matrix3 F{{{stretch(), 0, 0}, {0, stretch(), 0}, {0, 0, stretch()}}};
  return element(edges, F, some_poisson(random));
}

struct Kind {
  const char *name;
  int packs;  ///< how many to try
  Matrix (*make)(Random &random);
  double most_fallbacks;  ///< share of the matrices that may need split()

  friend void PrintTo(const Kind &kind, std::ostream *out) { *out << kind.name; }
};

template <int poisson>
Matrix stretched(Random &random) {
  return stretched_element(random, poisson / 1e4);
}

const double rare = 1e-3, any = 1;
const Kind kinds[] = {
    {"stretched_3", 15000, stretched<3000>, rare},
    {"stretched_495", 15000, stretched<4950>, rare},
    {"stretched_4999", 15000, stretched<4999>, rare},
    {"crushed", 20000, crushed_element, rare},
    {"collapsed", 8000, collapsed_element, 0.05},
    {"badly_shaped", 8000, badly_shaped_element, 0.005},
    {"calm", 10000, calm_element, 0.02},
    {"regular", 2000, regular_element, 0.05},
    {"random", 15000, random_symmetric, rare},
    {"any_count", 6000,
     [](Random &r) {
       const int count = pick(r, n + 1);
       return with_spectrum(r, [&](int k) { return (k < count ? -1 : 1) * uniform(r, 0.1, 1); });
     },
     rare},
    {"repeated", 2000,
     [](Random &r) {
       const int count = pick(r, n + 1);
       return with_spectrum(r, [&](int k) { return k < count ? -3.0 : 2.0; });
     },
     any},
    {"pairs", 2000,
     [](Random &r) {
       const int from = pick(r, n);
       return with_spectrum(r, [&](int k) { return double(k / 2 - from / 2) - 0.25; });
     },
     any},
    {"close", 1000,
     [](Random &r) {
       const double gap = std::pow(10.0, uniform(r, -17, -1));
       return with_spectrum(r, [&](int k) { return k < 4 ? -1 - k * gap : k; });
     },
     any},
    {"graded", 3000,
     [](Random &r) {
       const double step = uniform(r, 0.2, 2.2);
       return with_spectrum(
           r, [&](int k) { return (pick(r, 2) ? 1 : -1) * std::pow(10.0, -step * k); });
     },
     any},
    {"graded_by_rows", 2000,
     [](Random &r) {
       Matrix A = random_symmetric(r);
       const double step = uniform(r, 0.1, 2);
       for (int i = 0; i < n * n; ++i) A[i] *= std::pow(10.0, -step * (i / n + i % n));
       return A;
     },
     any},
    {"rank_deficient", 2000,
     [](Random &r) {
       const int rank = pick(r, n);
       return with_spectrum(r, [&](int k) { return k < rank ? uniform(r, 0.01, 1) : 0.0; });
     },
     rare},
    {"deficient_and_negative", 2000,
     [](Random &r) {
       const int rank = pick(r, n);
       return with_spectrum(r, [&](int k) { return k < rank ? uniform(r, -1, 1) : 0.0; });
     },
     any},
    {"negative_definite", 1000,
     [](Random &r) { return with_spectrum(r, [&](int) { return uniform(r, -1, -0.01); }); }, rare},
    {"barely_negative", 1000,
     [](Random &r) {
       const double size = std::pow(10.0, uniform(r, -17, -12));
       return with_spectrum(r, [&](int k) { return k == 0 ? -size : 0.5 + k; });
     },
     rare},
    {"diagonal", 500, [](Random &r) { return diagonal([&](int) { return pick(r, 7) - 3.0; }); },
     any},
    {"tridiagonal", 1000,
     [](Random &r) { return sparse(r, [](int i, int j) { return i - j <= 1; }); }, any},
    {"blocks", 1000,
     [](Random &r) { return sparse(r, [](int i, int j) { return i / 3 == j / 3; }); }, any},
    {"interleaved_blocks", 1000,
     [](Random &r) { return sparse(r, [](int i, int j) { return i % 3 == j % 3; }); }, any},
    {"holes", 2000, [](Random &r) { return sparse(r, [&](int, int) { return pick(r, 3) == 0; }); },
     any},
    {"arrow", 500,
     [](Random &r) { return sparse(r, [](int i, int j) { return j == 0 || i == j; }); }, any},
    {"zero", 10, [](Random &) { return Matrix{}; }, rare},
    {"scaled", 3000,
     [](Random &r) {
       Matrix A = pick(r, 2) ? random_symmetric(r) : crushed_element(r);
       const double scale = std::pow(10.0, uniform(r, -280, 280));
       for (double &a : A) a *= scale;
       return A;
     },
     rare},
};

// ---- Running it ---------------------------------------------------------------------------------

struct Parts {
  std::vector<double> N;
  std::vector<int> negative;
  SplitResult result;
  long fallbacks = 0;

  bool operator==(const Parts &other) const { return N == other.N && negative == other.negative; }
};

Parts split_packs(const std::vector<double> &K, InstructionSet instructions,
                  bool distrust = false) {
  const int packs = static_cast<int>(K.size()) / (reduced_entries * lanes);
  Parts parts{std::vector<double>(K.size(), 7.0), std::vector<int>(packs * lanes, -7), {}};
  ReducedSplitExperiment experiment{instructions, distrust};
  parts.result = split_reduced(packs, K.data(), parts.N.data(), parts.negative.data(), experiment);
  parts.fallbacks = experiment.fallbacks;
  return parts;
}

double packed_entry(const std::vector<double> &N, std::size_t matrix, int i, int j) {
  const int e = std::max(i, j) * (std::max(i, j) + 1) / 2 + std::min(i, j);
  return N[(matrix / lanes * reduced_entries + e) * lanes + matrix % lanes];
}

/// At most ||A||.
double longest_row(const Matrix &A) {
  double longest = 0;
  for (int i = 0; i < n; ++i) {
    double row = 0;  // hypot: squares could overflow
    for (int j = 0; j < n; ++j) row = std::hypot(row, A[n * i + j]);
    longest = std::max(longest, row);
  }
  return longest;
}

/// How many eigenvalues of A split() finds below `limit`.
int count_below(Matrix A, double limit) {
  for (int i = 0; i < n; ++i) A[n * i + i] -= limit;
  Matrix N;
  int negative = 0;
  (void)split(n, 1, A.data(), N.data(), &negative);
  return negative;
}

class ReducedFilter : public testing::TestWithParam<Kind> {};

TEST_P(ReducedFilter, AgreesWithSplit) {
  const Kind &kind = GetParam();
  Random random(1);
  double worst = 0;
  long fallbacks[3] = {}, matrices = 0, indefinite = 0;
  const int packs = kind.packs * (TREFOIL_REDUCED_TEST_PERCENT) / 100 + 1;
  for (int done = 0, stretch; done < packs; done += stretch) {
    stretch = std::min(500, packs - done);
    std::vector<Matrix> A(stretch * lanes), expected(A.size());
    for (Matrix &a : A) a = kind.make(random);
    std::vector<int> count(A.size());
    const SplitResult result =
        split(n, static_cast<int>(A.size()), A[0].data(), expected[0].data(), count.data());
    ASSERT_EQ(result.status, SplitStatus::ok);
    matrices += static_cast<long>(A.size());
    indefinite += result.indefinite;
    const std::vector<double> K = packed(A);
    for (InstructionSet set : instruction_sets()) {
      const Parts parts = split_packs(K, set);
      fallbacks[static_cast<int>(set)] += parts.fallbacks;
      ASSERT_EQ(parts.result.status, SplitStatus::ok);
      for (std::size_t m = 0; m < A.size(); ++m) {
        const double norm = longest_row(A[m]);
        double error = 0, size = 0;
        for (int i = 0; i < n; ++i) {
          for (int j = 0; j < n; ++j) {
            const double N_ij = packed_entry(parts.N, m, i, j);
            const double difference = norm > 0 ? (N_ij - expected[m][n * i + j]) / norm : N_ij;
            error += difference * difference;
            size = std::max(size, std::abs(N_ij));
          }
        }
        error = std::sqrt(error);
        worst = std::max(worst, error);
        ASSERT_LE(error, split_accuracy(n)) << name_of(set) << ", matrix " << m;
        // Around the threshold the count may fall either way.
        if (parts.negative[m] != count[m]) {
          const double threshold = n * DBL_EPSILON * norm;
          ASSERT_GE(parts.negative[m], count_below(A[m], -3 * threshold)) << name_of(set);
          ASSERT_LE(parts.negative[m], count_below(A[m], 3 * threshold)) << name_of(set);
        }
        if (parts.negative[m] == 0) {
          ASSERT_EQ(size, 0) << name_of(set) << ", matrix " << m;
        }
      }
    }
  }
  std::printf("%-24s %7ld matrices, %3.0f %% indefinite, largest error %.1e, to split()", kind.name,
              matrices, 100.0 * indefinite / matrices, worst);
  for (InstructionSet set : instruction_sets()) {
    std::printf(" %ld", fallbacks[static_cast<int>(set)]);
    EXPECT_LE(fallbacks[static_cast<int>(set)], kind.most_fallbacks * matrices + 5) << name_of(set);
  }
  std::printf("\n");
}

INSTANTIATE_TEST_SUITE_P(Kinds, ReducedFilter, testing::ValuesIn(kinds),
                         [](const auto &kind) { return std::string(kind.param.name); });

// ---- Its own promises ---------------------------------------------------------------------------

/// Some of every kind.
std::vector<Matrix> mixture(int each) {
  Random random(3);
  std::vector<Matrix> matrices;
  for (int repeat = 0; repeat < each; ++repeat) {
    for (const Kind &kind : kinds) matrices.push_back(kind.make(random));
  }
  return matrices;
}

class ReducedFilterBy : public testing::TestWithParam<InstructionSet> {};
INSTANTIATE_TEST_SUITE_P(Instructions, ReducedFilterBy, testing::ValuesIn(instruction_sets()),
                         [](const auto &set) { return std::string(name_of(set.param)); });

TEST_P(ReducedFilterBy, NeighboursDoNotMatter) {
  const std::vector<Matrix> A = mixture(40);
  const Parts together = split_packs(packed(A), GetParam());

  std::vector<std::size_t> order(A.size());
  std::iota(order.begin(), order.end(), 0);
  Random random(4);
  for (int repeat = 0; repeat < 3; ++repeat) {
    std::shuffle(order.begin(), order.end(), random);
    std::vector<Matrix> shuffled;
    for (std::size_t m : order) shuffled.push_back(A[m]);
    const Parts parts = split_packs(packed(shuffled), GetParam());
    for (std::size_t m = 0; m < A.size(); ++m) {
      ASSERT_EQ(parts.negative[m], together.negative[order[m]]);
      for (int e = 0; e < n * n; ++e) {
        ASSERT_EQ(packed_entry(parts.N, m, e / n, e % n),
                  packed_entry(together.N, order[m], e / n, e % n));
      }
    }
  }
  for (std::size_t m = 0; m < A.size(); ++m) {
    // Alone among zeros, so that a group has one member.
    std::vector<Matrix> alone(lanes);
    alone[m % lanes] = A[m];
    const Parts parts = split_packs(packed(alone), GetParam());
    ASSERT_EQ(parts.negative[m % lanes], together.negative[m]);
    for (int e = 0; e < n * n; ++e) {
      ASSERT_EQ(packed_entry(parts.N, m % lanes, e / n, e % n),
                packed_entry(together.N, m, e / n, e % n));
    }
  }
}

TEST_P(ReducedFilterBy, PowersOfTwoScaleExactly) {
  std::vector<Matrix> A = mixture(10);
  std::erase_if(A,
                [](const Matrix &a) { return !(longest_row(a) > 1e-20 && longest_row(a) < 1e20); });
  const std::vector<double> K = packed(A);
  const Parts parts = split_packs(K, GetParam());
  for (int exponent : {-500, -333, -1, 1, 64, 500, 900}) {
    std::vector<double> scaled = K;
    Parts expected = parts;
    for (double &k : scaled) k = std::ldexp(k, exponent);
    for (double &N : expected.N) N = std::ldexp(N, exponent);
    EXPECT_EQ(split_packs(scaled, GetParam()), expected) << exponent;
  }
}

TEST_P(ReducedFilterBy, FromSubnormalToTheLargestDoubles) {
  Random random(5);
  for (double scale : {1e-323, 1e-315, 1e-308, 1e-306, 1e-150, 1e150, 1e305, 1e307, 4e307}) {
    Matrix A = random_symmetric(random), expected;
    const double largest = std::abs(*std::max_element(
        A.begin(), A.end(), [](double x, double y) { return std::abs(x) < std::abs(y); }));
    for (double &a : A) a *= scale / largest;
    (void)split(n, 1, A.data(), expected.data(), nullptr);
    const Parts parts = split_packs(packed({A}), GetParam());
    for (int e = 0; e < n * n; ++e) {
      EXPECT_NEAR(packed_entry(parts.N, 0, e / n, e % n), expected[e],
                  scale * 1e-13 + DBL_TRUE_MIN);
    }
  }
}

TEST_P(ReducedFilterBy, DistrustSendsIndefiniteMatricesToSplit) {
  const std::vector<Matrix> A = mixture(10);
  const Parts trusting = split_packs(packed(A), GetParam());
  const Parts parts = split_packs(packed(A), GetParam(), true);
  EXPECT_GE(parts.fallbacks, trusting.result.indefinite);
  EXPECT_LT(parts.fallbacks, static_cast<long>(A.size()));
  for (std::size_t m = 0; m < A.size(); ++m) {
    Matrix expected;
    int negative = 0;
    (void)split(n, 1, A[m].data(), expected.data(), &negative);
    // The lanes' own test may call semi-definite what split() calls barely indefinite.
    if (parts.negative[m] == 0) continue;
    EXPECT_EQ(parts.negative[m], negative);
    for (int e = 0; e < n * n; ++e) {
      ASSERT_EQ(packed_entry(parts.N, m, e / n, e % n), expected[e]);
    }
  }
}

TEST_P(ReducedFilterBy, NonFiniteMatricesAreReportedAndNeighboursAreRight) {
  Random random(6);
  for (bool all_indefinite : {true, false}) {
    std::vector<Matrix> A(3 * lanes);
    for (Matrix &a : A) a = all_indefinite ? random_symmetric(random) : calm_element(random);
    const std::vector<double> good = packed(A);
    const Parts expected = split_packs(good, GetParam());
    ASSERT_EQ(expected.result.first_bad, -1);
    for (double poison : {nan, inf, -inf}) {
      for (std::size_t at = 0; at < good.size(); ++at) {
        std::vector<double> K = good;
        K[at] = K.back() = poison;  // a second one: the first is the one named
        const std::size_t last = A.size() - 1;
        const std::size_t bad = at / (reduced_entries * lanes) * lanes + at % lanes;
        const Parts parts = split_packs(K, GetParam());
        ASSERT_EQ(parts.result.status, SplitStatus::not_finite);
        ASSERT_EQ(parts.result.first_bad, static_cast<int>(bad));
        long indefinite = 0;
        for (std::size_t m = 0; m < A.size(); ++m) {
          const bool poisoned = m == bad || m == last;
          ASSERT_EQ(parts.negative[m], poisoned ? -1 : expected.negative[m]);
          indefinite += parts.negative[m] > 0;
          for (int e = 0; e < n * n; ++e) {
            const double N = packed_entry(parts.N, m, e / n, e % n);
            ASSERT_TRUE(poisoned ? std::isnan(N) : N == packed_entry(expected.N, m, e / n, e % n));
          }
        }
        ASSERT_EQ(parts.result.indefinite, indefinite);
      }
    }
  }
}

TEST_P(ReducedFilterBy, TwoThreadsGetTheSameAnswer) {
  const std::vector<double> K = packed(mixture(300));
  const Parts alone = split_packs(K, GetParam());
  Parts first, second;
  std::thread one([&] { first = split_packs(K, GetParam()); });
  std::thread two([&] { second = split_packs(K, GetParam()); });
  one.join();
  two.join();
  EXPECT_EQ(first, alone);
  EXPECT_EQ(second, alone);
}

TEST(ReducedFilterByItself, ChoosesAnInstructionSet) {
  const std::vector<double> K = packed(mixture(10));
  Parts parts{std::vector<double>(K.size()), std::vector<int>(K.size() / reduced_entries), {}};
  const int packs = static_cast<int>(K.size()) / (reduced_entries * lanes);
  parts.result = split_reduced(packs, K.data(), parts.N.data(), parts.negative.data());
  bool found = false;
  for (InstructionSet set : instruction_sets()) found = found || split_packs(K, set) == parts;
  EXPECT_TRUE(found);
}

TEST(ReducedFilterByItself, EmptyAndNegativeBatches) {
  EXPECT_EQ(split_reduced(0, nullptr, nullptr, nullptr).status, SplitStatus::ok);
  EXPECT_EQ(split_reduced(-1, nullptr, nullptr, nullptr).status, SplitStatus::bad_size);
}

}  // namespace
}  // namespace trefoil
