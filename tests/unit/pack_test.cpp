// Packs as a user's material sees them: formulas written for numbers, in a namespace that knows
// nothing of ours, found by their arguments alone.

#include "trefoil/pack.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace elsewhere {

/// What materials are made of, with numbers and integers among the packs.
template <class Real>
struct Formulas {
  Real a, b;

  [[nodiscard]] Real branch() const { return select(a < b, a * 2, 0.5); }
  [[nodiscard]] Real two_conditions() const {
    return select((a < 1.0) & !(b < 0.0), a, select((a >= 3.0) | (b <= -1.0), b, Real(7)));
  }
  [[nodiscard]] Real smaller() const { return min(a, b); }
  [[nodiscard]] Real at_most_one() const { return min(a, 1.0); }
  [[nodiscard]] Real larger() const { return max(a, b); }
  [[nodiscard]] Real at_least_one() const { return max(1.0, a); }
  [[nodiscard]] Real size() const { return abs(a); }
  [[nodiscard]] Real root() const { return sqrt(abs(b)); }
  [[nodiscard]] Real cubic_root() const { return cbrt(a); }
  [[nodiscard]] Real ogden() const { return pow(abs(a), 1.3) + pow(2.0, b) + pow(abs(a), b); }
  [[nodiscard]] Real fung() const { return exp(0.1 * a) + expm1(1e-9 * b); }
  [[nodiscard]] Real barrier() const { return log(abs(a)) - log1p(1e-9 * b); }
  [[nodiscard]] Real own_function() const {
    return by_lane([](double x) { return std::erf(x); }, a);
  }
  [[nodiscard]] Real updates() const {
    Real sum = a;
    sum += b;
    sum *= 3;
    sum -= a;
    sum /= 1.0 + b * b;
    return -sum;
  }
};

}  // namespace elsewhere

namespace trefoil::test {
namespace {

using Real = Pack<InstructionSet::baseline>;
using Formulas = elsewhere::Formulas<Real>;

const std::vector<double> numbers{-3, -1, -0.5, -1e-300, 0, 1e-300, 0.3, 1, 1.0001, 2.5, 3, 40};

/// Every formula, lane by lane, against the same with one number.
template <class Formula, class Expected>
void expect_lanes(Formula formula, Expected expected) {
  for (std::size_t shift = 0; shift < numbers.size(); ++shift) {
    Formulas packs;
    for (int lane = 0; lane < lanes; ++lane) {
      packs.a.v[lane] = numbers[static_cast<std::size_t>(lane) % numbers.size()];
      packs.b.v[lane] = numbers[(static_cast<std::size_t>(lane) + shift) % numbers.size()];
    }
    const Real result = (packs.*formula)();
    for (int lane = 0; lane < lanes; ++lane) {
      const double a = packs.a.v[lane], b = packs.b.v[lane];
      EXPECT_DOUBLE_EQ(result.v[lane], expected(a, b)) << a << ' ' << b;
    }
  }
}

TEST(PackTest, FormulasOfAnotherNamespaceAreThoseOfNumbers) {
  expect_lanes(&Formulas::branch, [](double a, double b) { return a < b ? 2 * a : 0.5; });
  expect_lanes(&Formulas::two_conditions, [](double a, double b) {
    if (a < 1 && b >= 0) return a;
    return a >= 3 || b <= -1 ? b : 7;
  });
  expect_lanes(&Formulas::smaller, [](double a, double b) { return std::min(a, b); });
  expect_lanes(&Formulas::at_most_one, [](double a, double) { return std::min(a, 1.0); });
  expect_lanes(&Formulas::larger, [](double a, double b) { return std::max(a, b); });
  expect_lanes(&Formulas::at_least_one, [](double a, double) { return std::max(a, 1.0); });
  expect_lanes(&Formulas::size, [](double a, double) { return std::abs(a); });
  expect_lanes(&Formulas::root, [](double, double b) { return std::sqrt(std::abs(b)); });
  expect_lanes(&Formulas::cubic_root, [](double a, double) { return std::cbrt(a); });
  expect_lanes(&Formulas::ogden, [](double a, double b) {
    return std::pow(std::abs(a), 1.3) + std::pow(2, b) + std::pow(std::abs(a), b);
  });
  expect_lanes(&Formulas::fung,
               [](double a, double b) { return std::exp(0.1 * a) + std::expm1(1e-9 * b); });
  expect_lanes(&Formulas::barrier,
               [](double a, double b) { return std::log(std::abs(a)) - std::log1p(1e-9 * b); });
  expect_lanes(&Formulas::own_function, [](double a, double) { return std::erf(a); });
  expect_lanes(&Formulas::updates,
               [](double a, double b) { return -((a + b) * 3 - a) / (1 + b * b); });
}

TEST(PackTest, SmallArgumentsKeepTheirDigits) {
  Formulas packs;
  for (int lane = 0; lane < lanes; ++lane) packs.a.v[lane] = std::pow(10, -2 * lane - 2);
  const Real logarithm = log1p(packs.a), power = expm1(packs.a);
  for (int lane = 0; lane < lanes; ++lane) {
    const double a = packs.a.v[lane];
    EXPECT_NEAR(logarithm.v[lane] / (a - a * a / 2 + a * a * a / 3), 1, a * a * a + 1e-15);
    EXPECT_NEAR(power.v[lane] / (a + a * a / 2 + a * a * a / 6), 1, a * a * a + 1e-15);
  }
}

TEST(PackTest, NotANumberStaysOneAndAnswersNo) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Real a(1.0), b(2.0);
  a.v[3] = nan;
  b.v[5] = nan;
  EXPECT_TRUE(std::isnan(min(a, b).v[3]));
  EXPECT_EQ(min(a, b).v[5], 1) << "the first of two";
  EXPECT_TRUE(std::isnan(max(a, b).v[3]));
  EXPECT_TRUE(std::isnan(abs(a).v[3]));
  EXPECT_FALSE(all(a < b));
  EXPECT_TRUE(any(a < b));
  EXPECT_FALSE(any(a > b));
  EXPECT_EQ(select(a < b, Real(1), Real(2)).v[3], 2);
}

}  // namespace
}  // namespace trefoil::test
