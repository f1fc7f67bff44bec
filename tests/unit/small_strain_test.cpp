// At small strains energies and stresses have all their digits: against the formulas as books have
// them, in numbers of more digits, and against Hooke's law.

#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "material_cases.hpp"
#include "trefoil/log1pmx.hpp"
#include "wide_number.hpp"

namespace trefoil::test {
namespace {

using WideMatrix = Matrix3<Wide>;

WideMatrix widened(const Matrix &A) {
  WideMatrix wide;
  for (std::size_t k = 0; k < 9; ++k) wide.entries[k] = A.entries[k];
  return wide;
}
WideMatrix sum(const WideMatrix &A, Wide factor, const WideMatrix &B) {
  WideMatrix C = A;
  for (std::size_t k = 0; k < 9; ++k) C.entries[k] += factor * B.entries[k];
  return C;
}
Wide dot(const WideMatrix &A, const WideMatrix &B) {
  Wide result = 0;
  for (std::size_t k = 0; k < 9; ++k) result += A.entries[k] * B.entries[k];
  return result;
}
const WideMatrix identity = widened(diagonal(1, 1, 1));
WideMatrix transposed(const WideMatrix &A) {
  WideMatrix B;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) B(i, j) = A(j, i);
  return B;
}
/// F^-T.
WideMatrix inverse_transposed(const WideMatrix &F) {
  WideMatrix B = cofactor(F);
  for (Wide &entry : B.entries) entry /= determinant(F);
  return B;
}
/// The rotation of F, by Newton's method R <- (R + R^-T)/2 [Higham 1986].
WideMatrix rotation(const WideMatrix &F) {
  WideMatrix R = F;
  for (int k = 0; k < 20; ++k) {
    R = sum(R, 1, inverse_transposed(R));
    for (Wide &entry : R.entries) entry /= 2;
  }
  return R;
}

/// P(F) of each model as books have it, in its constants.
struct Book {
  double mu, lambda, volume;  ///< of shear, Lame's, and the weight of a term in (J - 1)^2

  [[nodiscard]] WideMatrix stress(const std::string &name, const WideMatrix &F) const {
    const Wide J = determinant(F), I1 = dot(F, F);
    const WideMatrix C = cofactor(F), B = inverse_transposed(F);
    const WideMatrix FFF = product(F, product(transposed(F), F)), nothing{};
    const auto with_volume = [&](const WideMatrix &P) { return sum(P, volume * (J - 1), C); };
    if (name == "stable_neo_hookean") {
      return sum(sum(nothing, mu, F), volume * (J - 1 - Wide(mu) / volume), C);
    }
    if (name == "neo_hookean") return sum(sum(nothing, mu, F), lambda * wide_log(J) - mu, B);
    if (name == "mooney_rivlin") {
      const Wide c = Wide(mu) / 4;  // c1 = c2
      const WideMatrix P = sum(sum(nothing, 2 * c * (1 + I1), F), -2 * c, FFF);
      return with_volume(sum(P, -6 * c, C));
    }
    if (name == "arap") return with_volume(sum(sum(nothing, 2 * mu, F), -2 * mu, rotation(F)));
    if (name == "symmetric_dirichlet") {
      const WideMatrix BBB = product(B, product(transposed(B), B));
      return with_volume(sum(sum(nothing, Wide(mu) / 2, F), -Wide(mu) / 2, BBB));
    }
    if (name == "corotated") {
      const WideMatrix R = rotation(F);
      return sum(sum(nothing, 2 * mu, F), lambda * (dot(R, F) - 3) - 2 * mu, R);
    }
    if (name == "st_venant_kirchhoff") {
      return sum(sum(nothing, mu, FFF), Wide(lambda) / 2 * (I1 - 3) - mu, F);
    }
    EXPECT_EQ(name, "own_material");
    return sum(sum(nothing, mu * (1 + (I1 - 3) / 5), F), volume * (J - 1) - mu, C);
  }

  /// psi = integral of P(I + t H) : H over t from 0 to 1, by Gauss's formula of three points, for
  /// psi itself has few digits even in wide numbers.
  [[nodiscard]] Wide energy(const std::string &name, const WideMatrix &H) const {
    const Wide node = square_root(Wide(3) / 5) / 2;
    const auto slope = [&](Wide t) { return dot(stress(name, sum(identity, t, H)), H); };
    const Wide half = Wide(1) / 2;
    return (5 * slope(half - node) + 8 * slope(half) + 5 * slope(half + node)) / 18;
  }
};

class SmallStrainTest : public testing::TestWithParam<std::string> {
 protected:
  static constexpr double rounding = 4e-15;

  /// Of nu 0.3 and of a body that is nearly incompressible.
  template <class Visit>
  static void for_each_material(Visit visit) {
    for (const double poisson : {0.0, 0.3, 0.499}) {
      const ElasticConstants constants{3.0, poisson};
      for (const Candidate &candidate : materials) {
        if (candidate.name != GetParam()) continue;
        const double mu = constants.mu(), lambda = constants.lambda();
        const double volume = GetParam() == "stable_neo_hookean" ? lambda + mu
                              : GetParam() == "mooney_rivlin"    ? lambda + mu / 2
                              : GetParam() == "own_material"     ? lambda + 0.6 * mu
                                                                 : lambda;
        visit(candidate.make(constants), Book{mu, lambda, volume});
      }
    }
  }
};

constexpr double strains[] = {1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13, 1e-14, 1e-20, 1e-40};

TEST_P(SmallStrainTest, EnergyAndStressAreTheBooks) {
  for_each_material([](const AnyMaterial &material, const Book &book) {
    Random random(11);
    const double stiffness = norm(material.tangent(diagonal(1, 1, 1)));
    for (const double strain : {0.05, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14}) {
      for (int repeat = 0; repeat < 20; ++repeat) {
        const Matrix H = random.matrix(strain);
        const Deformation<double> deformation(H);
        const WideMatrix wide = widened(H);
        const WideMatrix P = book.stress(GetParam(), sum(identity, 1, wide));
        const WideMatrix error = sum(widened(material.stress_of(deformation)), -1, P);
        EXPECT_LE(static_cast<double>(square_root(dot(error, error))),
                  rounding * stiffness * norm(H))
            << strain;
        if (strain > 1e-3) continue;
        const Wide psi = book.energy(GetParam(), wide);
        EXPECT_NEAR(material.energy_density_of(deformation), static_cast<double>(psi),
                    rounding * stiffness * test::dot(H, H))
            << strain;
      }
    }
  });
}

TEST_P(SmallStrainTest, TangentIsTheBooks) {
  for_each_material([](const AnyMaterial &material, const Book &book) {
    Random random(12);
    const Wide h = 1e-10;
    for (const double strain : {0.05, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14}) {
      const Matrix H = random.matrix(strain), D = random.matrix();
      const auto stress = [&](Wide s) {
        return book.stress(GetParam(), sum(sum(identity, 1, widened(H)), s, widened(D)));
      };
      const Tangent<double> A = material.tangent_of(Deformation<double>(H));
      const Matrix AD = test::apply(A, D);
      const WideMatrix above = stress(h), below = stress(-h);
      for (std::size_t k = 0; k < 9; ++k) {
        const Wide slope = (above.entries[k] - below.entries[k]) / (2 * h);
        EXPECT_NEAR(AD.entries[k], static_cast<double>(slope), 1e-14 * norm(A)) << strain;
      }
    }
  });
}

/// Hooke's law with one constant of what is not linear, to strains that no formula in F knows.
TEST_P(SmallStrainTest, IsHookesLaw) {
  for_each_material([](const AnyMaterial &material, const Book &book) {
    Random random(13);
    const double stiffness = norm(material.tangent(diagonal(1, 1, 1)));
    for (const double strain : strains) {
      const Matrix H = random.matrix(strain);
      Matrix sigma;
      const double trace = H(0, 0) + H(1, 1) + H(2, 2);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          sigma(i, j) = book.mu * (H(i, j) + H(j, i)) + (i == j ? book.lambda * trace : 0);
      const double psi = test::dot(sigma, H) / 2, tolerance = rounding + 10 * strain;
      const Deformation<double> deformation(H);
      EXPECT_LE(norm(along(material.stress_of(deformation), -1, sigma)),
                tolerance * stiffness * norm(H))
          << strain;
      EXPECT_NEAR(material.energy_density_of(deformation), psi,
                  tolerance * stiffness * test::dot(H, H))
          << strain;
    }
  });
}

/// Turned by an angle, a strained body has the digits that its F has.
TEST_P(SmallStrainTest, RotationsCostNoMoreThanRoundingOfF) {
  for_each_material([](const AnyMaterial &material, const Book &) {
    Random random(14);
    const double stiffness = norm(material.tangent(diagonal(1, 1, 1)));
    for (const double angle : {1e-9, 1e-6, 1e-3, 1.0}) {
      Matrix Q = diagonal(1, 1, 1);
      Q(0, 0) = Q(1, 1) = std::cos(angle);
      Q(1, 0) = -(Q(0, 1) = std::sin(angle));
      const Matrix e = random.matrix(1e-3 * angle);
      const Deformation<double> straight(e);
      Matrix turned = along(Q * e, 1, less_identity(Q));  // Q (I + e) - I
      turned(0, 0) = Q(0, 0) * e(0, 0) + Q(0, 1) * e(1, 0) - 2 * std::pow(std::sin(angle / 2), 2);
      turned(1, 1) = Q(1, 0) * e(0, 1) + Q(1, 1) * e(1, 1) - 2 * std::pow(std::sin(angle / 2), 2);
      EXPECT_NEAR(material.energy_density_of(Deformation<double>(turned)),
                  material.energy_density_of(straight),
                  rounding * stiffness * test::dot(turned, turned))
          << angle;
    }
  });
}

INSTANTIATE_TEST_SUITE_P(All, SmallStrainTest,
                         testing::Values("stable_neo_hookean", "neo_hookean", "mooney_rivlin",
                                         "arap", "symmetric_dirichlet", "corotated",
                                         "st_venant_kirchhoff", "own_material"),
                         [](const auto &each) { return each.param; });

TEST(DeformationTest, InvariantsAreThoseOfF) {
  constexpr double wide_rounding = 1e-32;  // of the references
  Random random(15);
  for (const double size : {2.0, 1e-2, 1e-7, 1e-14}) {
    for (int repeat = 0; repeat < 50; ++repeat) {
      const Matrix H = random.matrix(size);
      const Deformation<double> deformation(H);
      const WideMatrix F = sum(identity, 1, widened(H)), C = cofactor(F);
      const Wide J = determinant(F);
      const double first = size * (1 + size * size), second = first * size;
      const auto expect = [&](double value, Wide expected, double scale) {
        EXPECT_NEAR(value, static_cast<double>(expected),
                    1e-14 * scale * (1 + size) + wide_rounding)
            << size;
      };
      expect(deformation.J_minus_1(), J - 1, first);
      expect(deformation.J(), J, 1 + first);
      expect(deformation.I1_minus_3(), dot(F, F) - 3, first);
      expect(deformation.I2_minus_3(), dot(C, C) - 3, first);
      expect(deformation.I1_distortion(), dot(F, F) - 3 - 2 * (J - 1), second);
      expect(deformation.I2_distortion(), dot(C, C) - 3 - 4 * (J - 1), second);
      const WideMatrix CF = product(transposed(F), F), B = inverse_transposed(F);
      const double of_J = 1 + 1 / std::abs(static_cast<double>(J));
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          expect(deformation.F()(i, j), F(i, j), 1 + first);
          expect(deformation.cofactor()(i, j), C(i, j), 1 + first);
          expect(deformation.cofactor_minus_identity()(i, j), C(i, j) - identity(i, j), first);
          expect(deformation.F_minus_cofactor()(i, j), F(i, j) - C(i, j), first);
          expect(deformation.green_strain()(i, j), (CF(i, j) - identity(i, j)) / 2, first);
          expect(deformation.inverse_transpose_minus_identity()(i, j), B(i, j) - identity(i, j),
                 first * of_J * of_J);
        }
    }
  }
}

TEST(PolarDecompositionTest, BiotStrainHasItsDigits) {
  Random random(16);
  for (const double size : {2.0, 0.3, 0.05, 1e-3, 1e-7, 1e-14, 1e-30}) {
    for (int repeat = 0; repeat < 50; ++repeat) {
      const Matrix H = random.matrix(size);
      const WideMatrix F = sum(identity, 1, widened(H));
      const auto stretch = signed_svd(deformed(along(H, 1, diagonal(1, 1, 1))).F()).stretch;
      if (stretch[2] < 0.1) continue;  // Newton's method gives the proper rotation only here
      const PolarDecomposition<double> polar{Deformation<double>(H)};
      const WideMatrix R = rotation(F), S = product(transposed(R), F);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          EXPECT_NEAR(polar.rotation(i, j), static_cast<double>(R(i, j)), 1e-14 / stretch[2]);
          if (size < 1e-20) {
            EXPECT_NEAR(polar.biot_strain(i, j), (H(i, j) + H(j, i)) / 2, 1e-15 * size);
            continue;
          }
          EXPECT_NEAR(polar.biot_strain(i, j), static_cast<double>(S(i, j) - identity(i, j)),
                      1e-14 * size);
        }
    }
  }
}

TEST(LogarithmTest, HasAllDigits) {
  for (int k = -3000; k <= 3000; ++k) {
    const double size = std::pow(10, -16.0 * std::abs(k) / 3000) * 0.999;
    const double x = k < 0 ? -size : 40 * size;
    const auto [log1p, log1pmx] = trefoil::logarithm(x);
    const Wide exact = wide_log(Wide(1) + x);
    EXPECT_NEAR(log1p / static_cast<double>(exact), 1, 1e-15) << x;
    // For the smallest, wide numbers have no digits of it left either: -x^2/2 + x^3/3.
    const Wide rest = std::abs(x) < 1e-7
                          ? -Wide(x) * x / 2 + Wide(x) * x * x / 3 - Wide(x) * x * x * x / 4
                          : exact - x;
    EXPECT_NEAR(log1pmx / static_cast<double>(rest), 1, 5e-15) << x;
  }
  EXPECT_EQ(log1pmx(0.0), 0);
  EXPECT_TRUE(std::isnan(log1pmx(-1.5)));
  EXPECT_EQ(log1pmx(-1.0), -std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace trefoil::test
