// Surfaces, weights of pairs, and the contact energy of whole surfaces with its derivatives.
#include "contact/contact_energy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "contact/barrier.hpp"
#include "contact/half_space.hpp"
#include "contact_cases.hpp"
#include "contact_surfaces.hpp"
#include "filter/filter.hpp"

namespace trefoil::contact {
namespace {

/// The corner (0,0,0), (1,0,0), (0,1,0), (0,0,1) as a surface of four triangles; areas 1/2 and
/// sqrt(3)/2.
Surface corner() {
  return make_surface(3,
                      {{{0, 0, 0}, 7, 0, 2, Role::prescribed},
                       {{1, 0, 0}, 8, 0, 1, Role::free},
                       {{0, 1, 0}, 9, 0, 1, Role::free},
                       {{0, 0, 1}, 10, 0, 0, Role::prescribed}},
                      {{{3, 2, 1}, 5}, {{2, 0, 3}, 2}, {{0, 1, 3}, 3}, {{1, 0, 2}, 4}});
}

TEST(Surface, SortsAndShares) {
  const Surface s = corner();
  using Facets = std::vector<std::array<int, 3>>;
  using Edges = std::vector<std::array<int, 2>>;
  EXPECT_EQ(s.facets, (Facets{{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}));
  EXPECT_EQ(s.edges, (Edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}));
  const double slanted = std::sqrt(3.0) / 2;
  EXPECT_DOUBLE_EQ(s.facet_data[3].area, slanted);
  EXPECT_DOUBLE_EQ(s.vertex_data[0].area, 0.5);
  EXPECT_DOUBLE_EQ(s.vertex_data[1].area, (1 + slanted) / 3);
  EXPECT_DOUBLE_EQ(s.edge_data[0].area, 1. / 3);
  EXPECT_DOUBLE_EQ(s.edge_data[5].area, (0.5 + slanted) / 3);
  EXPECT_EQ(s.vertex_data[0].stiffness, 2);
  EXPECT_EQ(s.vertex_data[1].stiffness, 3);
  EXPECT_EQ(s.edge_data[3].stiffness, 4);
  EXPECT_EQ(s.edge_data[2].role, Role::prescribed);
  EXPECT_EQ(s.edge_data[0].role, Role::free);
  EXPECT_EQ(s.facet_data[2].owner, 2);
  EXPECT_EQ(s.facet_data[3].owner, 1);
  const auto total = [](const std::vector<Primitive> &all) {
    return std::accumulate(all.begin(), all.end(), 0.0,
                           [](double sum, const Primitive &p) { return sum + p.area; });
  };
  EXPECT_DOUBLE_EQ(total(s.vertex_data), 1.5 + slanted);
  EXPECT_DOUBLE_EQ(total(s.edge_data), 1.5 + slanted);
}

TEST(Surface, Diagonal) {
  EXPECT_DOUBLE_EQ(body_diagonal(corner()), std::sqrt(3.0));
  Surface s = corner();
  s.vertices[3].role = Role::obstacle;
  EXPECT_DOUBLE_EQ(body_diagonal(s), std::sqrt(2.0));
  EXPECT_EQ(body_diagonal(make_surface(3, {}, {})), 0);
}

TEST(Surface, OfAPlaneBody) {
  const Surface s = make_surface(2, {{{0, 0, 0}}, {{3, 0, 0}}, {{0, 4, 0}}},
                                 {{{1, 2, -1}, 7}, {{2, 0, -1}, 8}, {{1, 0, -1}, 9}});
  using Edges = std::vector<std::array<int, 2>>;
  EXPECT_EQ(s.edges, (Edges{{0, 1}, {0, 2}, {1, 2}}));
  EXPECT_DOUBLE_EQ(s.vertex_data[0].area, 3.5);
  EXPECT_DOUBLE_EQ(s.vertex_data[1].area, 4);
  EXPECT_DOUBLE_EQ(s.edge_data[2].area, 5);
  EXPECT_EQ(s.vertex_data[1].stiffness, 7);
}

TEST(PairStiffness, QuartersOfAreasAndTheSofterPartner) {
  Surface s = corner();
  for (int k = 0; k < 4; ++k) {
    s.vertex_data[k].area = 1 + k;
    s.facet_data[k].area = 10 * (1 + k);
  }
  for (int k = 0; k < 6; ++k) s.edge_data[k].area = 100 * (1 + k);
  EXPECT_DOUBLE_EQ(pair_stiffness(s, {PairKind::vertex_triangle, 2, 3}), 3. / 4 * 2);
  EXPECT_DOUBLE_EQ(pair_stiffness(s, {PairKind::edge_edge, 0, 5}), 700. / 4 * 2);
  EXPECT_DOUBLE_EQ(pair_stiffness(s, {PairKind::vertex_edge, 2, 3}), 3. / 2 * 2);
  // The floor under a body counts with the body's areas.
  s.edge_data[5].role = s.vertex_data[3].role = Role::obstacle;
  s.edge_data[5].stiffness = s.vertex_data[3].stiffness = INFINITY;
  s.edge_data[5].area = s.vertex_data[3].area = 1e9;
  EXPECT_DOUBLE_EQ(pair_stiffness(s, {PairKind::edge_edge, 0, 5}), 200. / 4 * 3);
  EXPECT_DOUBLE_EQ(pair_stiffness(s, {PairKind::vertex_triangle, 3, 0}), 10. / 4 * 4);
}

/// Tetrahedra so near each other that every class is active.
struct Crowd {
  Surface surface;
  ContactLaw law;
  std::vector<double> x;
  std::vector<ContactPair> pairs;

  explicit Crowd(int seed, double scale = 1, int dim = 3) {
    std::mt19937 random(seed);
    surface = dim == 3 ? tetrahedra(12, 0.3 * scale, 1.2 * scale, random)
                       : polygons(12, 0.3 * scale, 2 * scale, random);
    law = {0.3 * scale, 1.5};
    x = surface.rest_positions();
    pairs = find_candidates(surface, x, {law.distance});
  }
  [[nodiscard]] double energy(const std::vector<double> &at) const {
    return contact_energy(surface, law, pairs, at);
  }
};

TEST(ContactEnergy, HasAllClasses) {
  const Crowd crowd(1);
  int found[4] = {};
  for (const ContactPair &pair : crowd.pairs) {
    const auto points = points_of(vertices_of(crowd.surface, pair), crowd.x);
    ++found[static_cast<int>(nearest_points(pair.kind, points).nearest)];
  }
  for (const int count : found) EXPECT_GT(count, 10);
}

/// Along random directions, in double precision and with the logarithm itself. Points of the crowd
/// cross, but no distance is near 0.
TEST(ContactEnergy, DerivativesOfWholeSurfaces) {
  for (const int dim : {2, 3}) {
    for (const int seed : {1, 2, 3}) {
      const Crowd crowd(seed, 1, dim);
      ASSERT_GT(least_gap(crowd.surface, crowd.pairs, crowd.x).gap, 1e-4);
      std::mt19937 random(10 + seed);
      std::normal_distribution<double> normal;
      std::vector<double> direction(crowd.x.size());
      for (std::size_t k = 0; k < direction.size(); ++k) {
        if (dim == 3 || k % 3 < 2) direction[k] = normal(random);
      }
      const auto at = [&](double t) {
        std::vector<double> moved = crowd.x;
        for (std::size_t k = 0; k < moved.size(); ++k) moved[k] += t * direction[k];
        return moved;
      };
      const auto slope = [&](double t) {
        std::vector<double> gradient(crowd.x.size());
        add_contact_gradient(crowd.surface, crowd.law, crowd.pairs, at(t), gradient);
        return std::inner_product(gradient.begin(), gradient.end(), direction.begin(), 0.0);
      };
      const double h = 1e-8;
      EXPECT_NEAR((crowd.energy(at(h)) - crowd.energy(at(-h))) / (2 * h) / slope(0), 1, 1e-5);
      double curvature = 0;
      contact_hessians(crowd.surface, crowd.law, crowd.pairs, crowd.x, [&](const PairHessian &H) {
        for (int i = 0; i < 12; ++i) {
          for (int j = 0; j < 12; ++j) {
            if (H.vertices[i / 3] < 0 || H.vertices[j / 3] < 0) continue;
            curvature += H.H[12 * i + j] * direction[3 * H.vertices[i / 3] + i % 3] *
                         direction[3 * H.vertices[j / 3] + j % 3];
          }
        }
      });
      EXPECT_NEAR((slope(h) - slope(-h)) / (2 * h) / curvature, 1, 1e-4);
    }
  }
}

/// N of the closed forms and of the reduced 9 x 9 matrices is that of the whole 12 x 12 matrix.
TEST(ContactEnergy, NegativePartsAreThoseOfTheWholeMatrix) {
  for (const int dim : {2, 3}) {
    const Crowd crowd(4, 1, dim);
    long pairs = 0, indefinite = 0;
    const long said = contact_hessians(
        crowd.surface, crowd.law, crowd.pairs, crowd.x, [&](const PairHessian &hessian) {
          std::array<double, 144> N;
          int negative = 0;
          ASSERT_EQ(split(12, 1, hessian.H.data(), N.data(), &negative).status, SplitStatus::ok);
          double largest = 0;
          for (const double h : hessian.H) largest = std::max(largest, std::abs(h));
          for (int k = 0; k < 144; ++k) ASSERT_NEAR(hessian.N[k], N[k], 2e-13 * 12 * largest);
          ++pairs;
          indefinite += negative > 0;
        });
    EXPECT_GT(pairs, 50);
    EXPECT_EQ(said, indefinite);
  }
}

/// Mollified pairs too: all edges of two sheets with parallel edges.
TEST(ContactEnergy, NegativePartsOfParallelEdges) {
  for (const double angle : {0.0, 0.001, 0.02}) {
    const Surface surface = two_sheets(3, angle, 0.02);
    const std::vector<double> x = surface.rest_positions();
    const ContactLaw law{0.05};
    const auto pairs = find_candidates(surface, x, {law.distance});
    long parallel = 0;
    contact_hessians(surface, law, pairs, x, [&](const PairHessian &hessian) {
      std::array<double, 144> N;
      int negative = 0;
      ASSERT_EQ(split(12, 1, hessian.H.data(), N.data(), &negative).status, SplitStatus::ok);
      double largest = 0;
      for (const double h : hessian.H) largest = std::max(largest, std::abs(h));
      for (int k = 0; k < 144; ++k) ASSERT_NEAR(hessian.N[k], N[k], 2e-13 * 12 * largest);
      parallel += negative > 2;
    });
    EXPECT_EQ(parallel > 0, angle > 0);
  }
}

/// B has the unit of kappa times a volume, at lengths from 1e-6 to 1e6.
TEST(ContactEnergy, ScalesWithLength) {
  const Crowd crowd(5);
  for (const double scale : {1e-6, 1e6}) {
    const Crowd scaled(5, scale);
    ASSERT_EQ(scaled.pairs, crowd.pairs);
    EXPECT_NEAR(scaled.energy(scaled.x) / std::pow(scale, 3) / crowd.energy(crowd.x), 1, 1e-12);
    std::vector<double> g(crowd.x.size()), of_scaled(crowd.x.size());
    add_contact_gradient(crowd.surface, crowd.law, crowd.pairs, crowd.x, g);
    add_contact_gradient(scaled.surface, scaled.law, scaled.pairs, scaled.x, of_scaled);
    const double largest = *std::max_element(g.begin(), g.end());
    for (std::size_t k = 0; k < g.size(); ++k) {
      EXPECT_NEAR(of_scaled[k] / (scale * scale), g[k], 1e-10 * largest);
    }
  }
}

/// Forces of contact add up to none, and turn nothing.
TEST(ContactEnergy, ForcesBalance) {
  const Crowd crowd(6);
  std::vector<double> gradient(crowd.x.size());
  add_contact_gradient(crowd.surface, crowd.law, crowd.pairs, crowd.x, gradient);
  Vector3 force, torque;
  double size = 0;
  for (int v = 0; v < crowd.surface.vertex_count(); ++v) {
    force = force + point_of(gradient, v);
    torque = torque + cross(point_of(crowd.x, v), point_of(gradient, v));
    size += norm(point_of(gradient, v));
  }
  EXPECT_LT(norm(force), 1e-14 * size);
  EXPECT_LT(norm(torque), 1e-13 * size);
}

/// Two sheets whose gap and dhat are small shares of an edge: under refinement the energy of the
/// common area A tends to a multiple of a barrier times A. Each vertex faces a triangle, w/4 from
/// either side, half of A; edges of lengths l with angle t cross l_i l_j |sin t| times in a square
/// of side 1, of w = 1/3 each, (w + w)/4. Without areas the energy would grow by four a refinement.
TEST(ContactEnergy, ConvergesUnderRefinement) {
  constexpr double angle = 0.4, right = 1.5707963267948966;
  const double length[] = {1, 1, std::sqrt(2.0)}, direction[] = {0, right, right / 2};
  double share = 0.5;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      share += length[i] * length[j] * std::abs(std::sin(direction[i] - direction[j] - angle)) / 6;
    }
  }
  share *= 2 / (1 + std::sin(angle) + std::cos(angle));  // A of two squares of side 1
  for (const int n : {16, 32, 64}) {
    const double gap = 1e-4 / n;
    const Surface surface = two_sheets(n, angle, gap);
    const auto x = surface.rest_positions();
    const ContactLaw law{2 * gap};
    const auto pairs = find_candidates(surface, x, {law.distance});
    const double energy = contact_energy(surface, law, pairs, x);
    EXPECT_NEAR(energy / barrier_value(gap, 2 * gap) / share, 1, 0.7 / n) << n;
  }
}

TEST(ContactEnergy, IsInfiniteWhereAPairTouches) {
  Crowd crowd(7);
  const double before = crowd.energy(crowd.x);
  EXPECT_TRUE(std::isfinite(before));
  const auto vertices = vertices_of(crowd.surface, crowd.pairs[0]);
  for (int i = 0; i < 3; ++i) crowd.x[3 * vertices[0] + i] = crowd.x[3 * vertices[1] + i];
  EXPECT_TRUE(std::isinf(crowd.energy(crowd.x)));
  EXPECT_EQ(least_gap(crowd.surface, crowd.pairs, crowd.x).gap, 0);
}

TEST(LeastGap, NamesThePair) {
  const Crowd crowd(8);
  const LeastGap least = least_gap(crowd.surface, crowd.pairs, crowd.x);
  ASSERT_GE(least.pair, 0);
  EXPECT_TRUE(pairs_within(crowd.surface, crowd.pairs, crowd.x, least.gap).empty());
  const auto nearest =
      pairs_within(crowd.surface, crowd.pairs, crowd.x, std::nextafter(least.gap, 1));
  ASSERT_EQ(nearest.size(), 1U);
  EXPECT_EQ(nearest[0], crowd.pairs[least.pair]);
  EXPECT_TRUE(std::isinf(least_gap(crowd.surface, {}, crowd.x).gap));
}

TEST(HalfSpace, EnergyDerivativesAndSteps) {
  std::mt19937 random(9);
  const Surface surface = tetrahedra(8, 0.2, 1, random);
  std::vector<double> x = surface.rest_positions();
  std::vector<int> vertices(surface.vertex_count());
  std::iota(vertices.begin(), vertices.end(), 0);
  HalfSpace plane{{0.48, 0.6, 0.64}, 0};
  plane.offset = least_gap(plane, vertices, x).gap - 0.05;
  EXPECT_NEAR(least_gap(plane, vertices, x).gap, 0.05, 1e-15);
  const ContactLaw law{0.8, 2};

  const auto energy = [&](double t, int k) {
    std::vector<double> moved = x;
    moved[k] += t;
    return half_space_energy(surface, law, plane, vertices, moved);
  };
  std::vector<double> gradient(x.size()), curvature(x.size() / 3);
  add_half_space_gradient(surface, law, plane, vertices, x, gradient);
  half_space_hessians(surface, law, plane, vertices, x,
                      [&](int vertex, double c) { curvature[vertex] = c; });
  double most = 0;
  for (const double g : gradient) most = std::max(most, std::abs(g));
  int active = 0;
  for (int k = 0; k < static_cast<int>(x.size()); ++k) {
    const double h = 1e-5, n = plane.normal[k % 3];
    EXPECT_NEAR((energy(h, k) - energy(-h, k)) / (2 * h), gradient[k], 1e-6 * most);
    const double second = (energy(h, k) - 2 * energy(0, k) + energy(-h, k)) / (h * h);
    EXPECT_NEAR(second, curvature[k / 3] * n * n, 1e-3 * most);
    active += curvature[k / 3] > 0;
  }
  EXPECT_GT(active, 6);
  EXPECT_LT(active, static_cast<int>(x.size()));

  // Head-on: nine tenths of the way. With a plane that follows: all of it.
  std::vector<double> step(x.size());
  for (std::size_t k = 0; k < step.size(); ++k) step[k] = -0.1 * plane.normal[k % 3];
  const AllowedStep allowed = allowed_step(plane, plane, vertices, x, step, {});
  EXPECT_NEAR(allowed.step, 0.9 * 0.05 / 0.1, 1e-12);
  EXPECT_EQ(allowed.pair, least_gap(plane, vertices, x).pair);
  EXPECT_EQ(allowed_step(plane, {plane.normal, plane.offset - 0.1}, vertices, x, step, {}).step, 1);
  for (double &s : step) s = -s;
  EXPECT_EQ(allowed_step(plane, plane, vertices, x, step, {}).step, 1);
  // A plane that comes nearer than the still vertices bear.
  EXPECT_NEAR(allowed_step(plane, {plane.normal, plane.offset + 0.1}, vertices, x,
                           std::vector<double>(x.size()), {})
                  .step,
              0.45, 1e-12);
  x[0] -= plane.normal.x;
  EXPECT_TRUE(std::isinf(half_space_energy(surface, law, plane, vertices, x)));
}

}  // namespace
}  // namespace trefoil::contact
