// The linear tetrahedron against linear fields, finite differences and the closed form of its
// stable Neo-Hookean Hessian.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "material/stable_neo_hookean.hpp"
#include "matrix3_support.hpp"
#include "tet4_support.hpp"

namespace trefoil::test {
namespace {

using Corners = std::array<std::array<double, 3>, 4>;
using Displacement = std::array<double, 12>;
using Hessian = std::array<double, 144>;

struct Shape {
  std::string name;
  Corners corner;

  friend std::ostream &operator<<(std::ostream &stream, const Shape &each) {
    return stream << each.name;
  }
};

std::vector<Shape> shapes() {
  std::vector<Shape> list{
      {"unit", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}},
      {"sliver", {{{0, 0, 0}, {1, 0, 1e-4}, {1, 1, 0}, {0, 1, 1e-4}}}},
      {"needle", {{{0, 0, 0}, {1e-3, 0, 0}, {0, 1e-3, 0}, {0, 0, 1}}}},
      {"flat", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1e-5}}}},
      {"far away", {{{1e3, 1e3, 1e3}, {1001, 1e3, 1e3}, {1e3, 1001, 1e3}, {1e3, 1e3, 1001}}}}};
  Random random(3);
  while (list.size() < 25) {
    Shape shape{"random " + std::to_string(list.size()), {}};
    for (auto &point : shape.corner)
      for (double &x : point) x = random.uniform();
    double corner[4][3];
    for (std::size_t a = 0; a < 4; ++a) std::copy_n(shape.corner[a].begin(), 3, corner[a]);
    if (Tet4::at_rest(corner).volume > 1e-3) list.push_back(shape);
  }
  return list;
}

/// The tetrahedron at length * (Q corners) + shift.
Tet4 make(const Corners &corners, double length = 1, const Matrix &Q = diagonal(1, 1, 1),
          double shift = 0) {
  double corner[4][3];
  for (int a = 0; a < 4; ++a)
    for (int i = 0; i < 3; ++i) {
      double turned = 0;
      for (int j = 0; j < 3; ++j)
        turned += Q(i, j) * corners[static_cast<std::size_t>(a)][static_cast<std::size_t>(j)];
      corner[a][i] = length * turned + shift;
    }
  return Tet4::at_rest(corner);
}

/// How far from the origin a corner lies, at most: there the differences of corners lose digits.
double distance(const Corners &corners) {
  double largest = 0;
  for (const auto &p : corners) largest = std::max(largest, std::hypot(p[0], p[1], p[2]));
  return largest;
}

double largest_gradient(const Tet4 &tet) {
  double largest = 0;
  for (const auto &g : tet.gradients) largest = std::max(largest, std::hypot(g[0], g[1], g[2]));
  return largest;
}

const StableNeoHookean material({2.0, 0.4}, StableNeoHookean::Lame::physical);

double energy(const Tet4 &tet, const Displacement &u) {
  return tet.volume * material.energy_density(Deformation(tet.displacement_gradient(u.data())));
}

Displacement force(const Tet4 &tet, const Displacement &u) {
  Displacement f{};
  tet.add_force(material.stress(Deformation(tet.displacement_gradient(u.data()))), f.data());
  return f;
}

Hessian hessian(const Tet4 &tet, const Displacement &u) {
  Tangent<double> A;
  material.tangent(Deformation(tet.displacement_gradient(u.data())), A);
  Hessian H;
  tet.hessian(A, H.data());
  return H;
}

/// Displacements that strain the element by about `strain`, whatever its shape.
Displacement strained(const Tet4 &tet, double strain, Random &random) {
  Displacement u;
  for (double &entry : u) entry = strain / largest_gradient(tet) * random.uniform();
  return u;
}

class Tet4Test : public testing::TestWithParam<Shape> {
 protected:
  Tet4 tet_ = make(GetParam().corner);
  double gradient_ = largest_gradient(tet_);
  Random random_{4};
};

TEST_P(Tet4Test, ShapeFunctionsAreOneTogetherAndLinear) {
  for (int j = 0; j < 3; ++j) {
    double sum = 0;
    for (const auto &g : tet_.gradients) sum += g[j];
    EXPECT_NEAR(sum, 0, 4e-16 * gradient_);
  }
  // Shape function a is 1 at corner a, 0 at the others.
  const Corners &x = GetParam().corner;
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < 4; ++b)
      for (std::size_t from = 0; from < 4; ++from) {
        double difference = 0, size = 0;
        for (std::size_t j = 0; j < 3; ++j) {
          difference += tet_.gradients[a][j] * (x[b][j] - x[from][j]);
          size += std::abs(tet_.gradients[a][j] * (x[b][j] - x[from][j]));
        }
        EXPECT_NEAR(difference, (a == b ? 1 : 0) - (a == from ? 1 : 0), 1e-12 * (1 + size));
      }
}

// The patch test.
TEST_P(Tet4Test, AffineDisplacementsGiveTheirGradientExactly) {
  for (int repeat = 0; repeat < 10; ++repeat) {
    const Matrix F = random_.matrix(2), I = diagonal(1, 1, 1);
    const double shift = random_.uniform();
    Displacement u{};
    double rounding = 0;
    for (std::size_t a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) {
        double &entry = u[3 * a + static_cast<std::size_t>(i)];
        entry = shift;
        for (int j = 0; j < 3; ++j)
          entry += (F(i, j) - I(i, j)) * GetParam().corner[a][static_cast<std::size_t>(j)];
        rounding = std::max(rounding, std::abs(entry) * gradient_);
      }
    EXPECT_LE(norm(along(tet_.displacement_gradient(u.data()), -1, less_identity(F))),
              1e-14 * (1 + rounding));
  }
}

TEST_P(Tet4Test, VolumeIsAThirdOfBaseTimesHeightAndChangesItsSignWithTheOrder) {
  const Corners &x = GetParam().corner;
  Matrix edges;
  for (int i = 0; i < 3; ++i)
    for (int a = 1; a < 4; ++a)
      edges(i, a - 1) = x[static_cast<std::size_t>(a)][static_cast<std::size_t>(i)] -
                        x[0][static_cast<std::size_t>(i)];
  EXPECT_NEAR(tet_.volume, determinant(edges) / 6, 1e-15 * std::pow(norm(edges), 3));
  // 1/|g_0| is the height over the face of corners 1 to 3.
  double u[3], v[3], area = 0, height = 0;
  for (std::size_t i = 0; i < 3; ++i) u[i] = x[2][i] - x[1][i], v[i] = x[3][i] - x[1][i];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    area += std::pow(u[j] * v[k] - u[k] * v[j], 2) / 4;
    height += tet_.gradients[0][i] * tet_.gradients[0][i];
  }
  EXPECT_NEAR(std::abs(tet_.volume) * 3 * std::sqrt(height) / std::sqrt(area), 1, 1e-10);

  Corners turned = x;
  std::swap(turned[1], turned[2]);
  EXPECT_DOUBLE_EQ(make(turned).volume, -tet_.volume);
}

TEST_P(Tet4Test, ForceAndHessianAreDerivatives) {
  for (const double strain : {0.0, 0.2, 1.5}) {  // with 1.5 many are inverted
    const Displacement u = strained(tet_, strain, random_);
    const Displacement f = force(tet_, u);
    const Hessian H = hessian(tet_, u);
    const double h = 1e-3 / gradient_;
    for (std::size_t p = 0; p < 12; ++p) {
      const auto moved = [&](double s) {
        Displacement at = u;
        at[p] += s;
        return at;
      };
      EXPECT_NEAR(derivative(h, [&](double s) { return energy(tet_, moved(s)); }), f[p],
                  1e-8 * (largest(f) + largest(H) / gradient_));
      for (std::size_t q = 0; q < 12; ++q)
        EXPECT_NEAR(derivative(h, [&](double s) { return force(tet_, moved(s))[q]; }),
                    H[12 * q + p], 1e-8 * largest(H));
    }
  }
}

TEST_P(Tet4Test, ForcesAreAdded) {
  const Displacement u = strained(tet_, 0.3, random_), once = force(tet_, u);
  Displacement twice = once;
  tet_.add_force(material.stress(Deformation(tet_.displacement_gradient(u.data()))), twice.data());
  for (std::size_t p = 0; p < 12; ++p) EXPECT_DOUBLE_EQ(twice[p], 2 * once[p]);
}

// H_ab = V [ mu (g_a.g_b) I + lambda c_a c_b' - lambda (J - alpha) [F (g_a x g_b)]_x ] with
// c_a = cof(F) g_a and [w]_x v = w x v.
TEST_P(Tet4Test, HessianHasItsClosedForm) {
  const double mu = material.mu(), lambda = material.lambda(), alpha = 1 + mu / lambda;
  for (const double strain : {0.0, 0.3, 2.0}) {
    const Displacement u = strained(tet_, strain, random_);
    const Hessian H = hessian(tet_, u);
    const Matrix F = Deformation(tet_.displacement_gradient(u.data())).F(), C = cofactor(F);
    const double pressure = lambda * (determinant(F) - alpha);
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const auto &ga = tet_.gradients[a], &gb = tet_.gradients[b];
        double product = 0, ca[3]{}, cb[3]{}, w[3]{};
        for (int j = 0; j < 3; ++j) {
          const double cross =
              ga[(j + 1) % 3] * gb[(j + 2) % 3] - ga[(j + 2) % 3] * gb[(j + 1) % 3];
          product += ga[j] * gb[j];
          for (int i = 0; i < 3; ++i) {
            ca[i] += C(i, j) * ga[j];
            cb[i] += C(i, j) * gb[j];
            w[i] += F(i, j) * cross;
          }
        }
        Matrix spin;
        spin.entries = {0, -w[2], w[1], w[2], 0, -w[0], -w[1], w[0], 0};
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k) {
            const double closed =
                (i == k ? mu * product : 0) + lambda * ca[i] * cb[k] - pressure * spin(i, k);
            EXPECT_NEAR(H[static_cast<std::size_t>(12 * (3 * a + i) + 3 * b + k)],
                        tet_.volume * closed, 1e-13 * largest(H));
          }
      }
  }
}

TEST_P(Tet4Test, HessianIsSymmetricAndBlindToTranslations) {
  const Hessian H = hessian(tet_, strained(tet_, 1.0, random_));
  for (std::size_t p = 0; p < 12; ++p) {
    for (std::size_t q = 0; q < 12; ++q)
      EXPECT_NEAR(H[12 * p + q], H[12 * q + p], 1e-14 * largest(H));
    for (std::size_t i = 0; i < 3; ++i) {
      double sum = 0;
      for (std::size_t a = 0; a < 4; ++a) sum += H[12 * p + 3 * a + i];
      EXPECT_NEAR(sum, 0, 1e-13 * largest(H));
    }
  }
}

// The material is isotropic: a turned body has the turned Hessian, block by block Q H_ab Q'.
TEST_P(Tet4Test, ATurnedElementHasTheTurnedHessian) {
  const Matrix Q = random_.rotation();
  const Tet4 turned = make(GetParam().corner, 1, Q, 0.5);
  const Displacement u = strained(tet_, 0.5, random_);
  Displacement turned_u{};
  for (std::size_t a = 0; a < 4; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        turned_u[3 * a + static_cast<std::size_t>(i)] +=
            Q(i, j) * u[3 * a + static_cast<std::size_t>(j)];
  const Hessian H = hessian(tet_, u), turned_H = hessian(turned, turned_u);
  const double tolerance = 1e-13 * (1 + distance(GetParam().corner) * gradient_) * largest(H);
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      Matrix block, turned_block, transposed;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
          const auto at = static_cast<std::size_t>(12 * (3 * a + i) + 3 * b + k);
          block(i, k) = H[at];
          turned_block(i, k) = turned_H[at];
          transposed(i, k) = Q(k, i);
        }
      EXPECT_LE(norm(along(turned_block, -1, Q * block * transposed)), tolerance);
    }
}

// Energy grows as length^3, forces as length^2, the Hessian as length; F stays as it is.
TEST_P(Tet4Test, LengthsHaveNoUnit) {
  for (const double length : {1e-6, 1.0, 1e6}) {
    const Tet4 scaled = make(GetParam().corner, length);
    const Displacement u = strained(tet_, 0.5, random_);
    Displacement scaled_u = u;
    for (double &entry : scaled_u) entry *= length;
    const Hessian H = hessian(tet_, u), scaled_H = hessian(scaled, scaled_u);
    const Displacement f = force(tet_, u), scaled_f = force(scaled, scaled_u);
    const double tolerance = 1e-13 * (1 + distance(GetParam().corner) * gradient_);
    EXPECT_NEAR(energy(scaled, scaled_u) / std::pow(length, 3), energy(tet_, u),
                tolerance * energy(tet_, u));
    for (std::size_t p = 0; p < 12; ++p)
      EXPECT_NEAR(scaled_f[p] / (length * length), f[p],
                  tolerance * (largest(f) + largest(H) / gradient_));
    for (std::size_t p = 0; p < 144; ++p)
      EXPECT_NEAR(scaled_H[p] / length, H[p], tolerance * largest(H));
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, Tet4Test, testing::ValuesIn(shapes()), [](const auto &each) {
  std::string name = each.param.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
});

}  // namespace
}  // namespace trefoil::test
