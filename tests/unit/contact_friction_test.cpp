// Lagged friction: the smooth law, forces and Hessians against differences, no negative part.
#include "contact/friction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "contact_surfaces.hpp"
#include "filter/filter.hpp"

namespace trefoil::contact {
namespace {

TEST(Sliding, IsTwiceSmooth) {
  const double e = 0.01, h = 1e-7;
  for (const double y : {1e-4, 0.003, 0.0099, 0.0101, 0.5}) {
    const Sliding at = sliding(y, e), before = sliding(y - h, e), after = sliding(y + h, e);
    EXPECT_NEAR((after.f0 - before.f0) / (2 * h), at.f1, 1e-8);
    EXPECT_NEAR((after.f1 - before.f1) / (2 * h), at.f2, 1e-6 / e);
    EXPECT_NEAR(at.f1_over_y * y, at.f1, 1e-15);
    EXPECT_GE(at.f2, 0);
  }
  const Sliding below = sliding(std::nextafter(e, 0), e), above = sliding(e, e);
  EXPECT_NEAR(below.f0, above.f0, 1e-16);
  EXPECT_DOUBLE_EQ(below.f1, above.f1);
  EXPECT_DOUBLE_EQ(below.f1_over_y, above.f1_over_y);
  EXPECT_NEAR(below.f2, above.f2, 1e-12);
  EXPECT_EQ(sliding(0, e).f1, 0);
  EXPECT_EQ(sliding(0, e).f1_over_y, 2 / e);
}

struct Rubbing {
  Surface surface;
  ContactLaw law{0.3, 1.5};
  std::vector<double> x;
  std::vector<ContactPair> pairs;
  std::vector<FrictionPair> lagged;

  explicit Rubbing(int dim) {
    std::mt19937 random(1);
    surface = dim == 3 ? tetrahedra(12, 0.3, 1.2, random) : polygons(12, 0.3, 2, random);
    x = surface.rest_positions();
    pairs = find_candidates(surface, x, {law.distance});
    lagged =
        lagged_friction(surface, law, pairs, x, [](int a, int b) { return (a + b) % 3 ? 0.5 : 0; });
  }
};

TEST(LaggedFriction, ForceIsThatOfTheBarrier) {
  for (const int dim : {2, 3}) {
    const Rubbing rubbing(dim);
    std::size_t next = 0;
    for (const ContactPair &pair : pairs_within(rubbing.surface, rubbing.pairs, rubbing.x, 0.3)) {
      const int a = first_of(rubbing.surface, pair).body, b = second_of(rubbing.surface, pair).body;
      if ((a + b) % 3 == 0) continue;
      ASSERT_LT(next, rubbing.lagged.size());
      const FrictionPair &lagged = rubbing.lagged[next++];
      EXPECT_EQ(lagged.vertices, vertices_of(rubbing.surface, pair));
      // The forces on the first primitive's vertices add up to lambda along the normal, but for the
      // mollifier's own part, which turns the edges.
      std::vector<double> gradient(rubbing.x.size());
      add_contact_gradient(rubbing.surface, rubbing.law, {&pair, 1}, rubbing.x, gradient);
      Vector3 force;
      for (int k = 0; k < points_of_first(pair.kind); ++k) {
        force = force + point_of(gradient, lagged.vertices[k]);
      }
      EXPECT_NEAR(0.5 * norm(force) / lagged.force, 1, 1e-9);
      for (const Vector3 &t : lagged.tangents) {
        EXPECT_NEAR(norm(t), 1, 1e-14);
        EXPECT_NEAR(dot(t, force) / norm(force), 0, 1e-9);
      }
      EXPECT_NEAR(dot(lagged.tangents[0], lagged.tangents[1]), 0, 1e-14);
      if (dim == 2) {
        EXPECT_EQ(lagged.tangents[0].z, 0);
        EXPECT_NEAR(std::abs(lagged.tangents[1].z), 1, 1e-15);
      }
    }
    EXPECT_EQ(next, rubbing.lagged.size());
    EXPECT_GT(next, 20U);
  }
}

TEST(LaggedFriction, Derivatives) {
  for (const int dim : {2, 3}) {
    const Rubbing rubbing(dim);
    for (const double size : {0.002, 0.01, 0.1}) {  // stick, both, slip
      std::mt19937 random(2);
      std::normal_distribution<double> normal(0, size);
      std::vector<double> v(rubbing.x.size()), direction(rubbing.x.size());
      for (std::size_t k = 0; k < v.size(); ++k) {
        if (dim == 2 && k % 3 == 2) continue;
        v[k] = normal(random);
        direction[k] = normal(random) / size;
      }
      const double e = 0.01, h = 1e-7;
      const auto at = [&](double t) {
        std::vector<double> moved = v;
        for (std::size_t k = 0; k < v.size(); ++k) moved[k] += t * direction[k];
        return moved;
      };
      const auto slope = [&](double t) {
        std::vector<double> gradient(v.size());
        add_friction_gradient(rubbing.lagged, at(t), e, gradient);
        return std::inner_product(gradient.begin(), gradient.end(), direction.begin(), 0.0);
      };
      const double difference =
          (friction_energy(rubbing.lagged, at(h), e) - friction_energy(rubbing.lagged, at(-h), e)) /
          (2 * h);
      double curvature = 0, force = 0;
      for (const FrictionPair &pair : rubbing.lagged) force += pair.force;
      friction_hessians(rubbing.lagged, v, e, [&](const FrictionHessian &hessian) {
        for (int i = 0; i < 12; ++i) {
          for (int j = 0; j < 12; ++j) {
            if (hessian.vertices[i / 3] < 0 || hessian.vertices[j / 3] < 0) continue;
            curvature += hessian.H[12 * i + j] * direction[3 * hessian.vertices[i / 3] + i % 3] *
                         direction[3 * hessian.vertices[j / 3] + j % 3];
          }
        }
        std::array<double, 144> N;
        int negative = 0;
        ASSERT_EQ(split(12, 1, hessian.H.data(), N.data(), &negative).status, SplitStatus::ok);
        EXPECT_EQ(negative, 0);
      });
      EXPECT_NEAR(difference, slope(0), 1e-6 * force);
      EXPECT_NEAR((slope(h) - slope(-h)) / (2 * h) / curvature, 1, 1e-4);
    }
  }
}

/// At rest, and where nothing but the normal direction moves, there is no force, and the Hessian is
/// the round one of sticking.
TEST(LaggedFriction, AtRest) {
  const Rubbing rubbing(3);
  const std::vector<double> v(rubbing.x.size());
  std::vector<double> gradient(v.size());
  add_friction_gradient(rubbing.lagged, v, 0.01, gradient);
  for (const double g : gradient) EXPECT_EQ(g, 0);
  std::size_t k = 0;
  friction_hessians(rubbing.lagged, v, 0.01, [&](const FrictionHessian &hessian) {
    const FrictionPair &pair = rubbing.lagged[k++];
    double trace = 0, squares = 0;
    for (int i = 0; i < 12; ++i) trace += hessian.H[13 * i];
    for (const double weight : pair.weights) squares += weight * weight;
    EXPECT_NEAR(trace / (2 * pair.force * squares * 2 / 0.01), 1, 1e-12);
  });
}

/// A block on a moving belt: only the motion against the belt counts.
TEST(LaggedFriction, AgainstAMovingHalfSpace) {
  std::mt19937 random(3);
  const Surface surface = tetrahedra(1, 0.3, 0, random);
  const auto x = surface.rest_positions();
  const std::vector<int> vertices = {0, 1, 2, 3};
  HalfSpace plane{{0, 0, 1}, 0};
  plane.offset = least_gap(plane, vertices, x).gap - 0.05;
  const ContactLaw law{0.1, 1};
  auto lagged = lagged_friction(surface, law, plane, vertices, x, 0.4);
  ASSERT_EQ(lagged.size(), 1U);
  std::vector<double> gradient(x.size());
  add_half_space_gradient(surface, law, plane, vertices, x, gradient);
  const int touching = lagged[0].vertices[0];
  EXPECT_NEAR(lagged[0].force, -0.4 * gradient[3 * touching + 2], 1e-15);

  lagged[0].drift = {0.3, 0, 0};
  std::vector<double> v(x.size()), force(x.size());
  add_friction_gradient(lagged, v, 1e-3, force);  // it slides backwards
  EXPECT_NEAR(force[3 * touching], -lagged[0].force, 1e-15);
  v[3 * touching] = 0.3;
  std::fill(force.begin(), force.end(), 0);
  add_friction_gradient(lagged, v, 1e-3, force);  // it rides along
  for (const double f : force) EXPECT_EQ(f, 0);
  EXPECT_NEAR(friction_energy(lagged, v, 1e-3), lagged[0].force * 1e-3 / 3, 1e-18);
}

}  // namespace
}  // namespace trefoil::contact
