// Allowed steps against impacts that are known exactly, and against roots in quadruple precision.
#include "contact/additive_ccd.hpp"

#include "contact/intersections.hpp"
#include "contact/separation.hpp"
#include "contact_cases.hpp"
#include "contact_surfaces.hpp"

namespace trefoil::contact {
namespace {

/// A pair and its motion.
struct Moving {
  PairKind kind = PairKind::vertex_triangle;
  PairPoints x, step;

  /// In quadruple precision: x + t step, and the distance there.
  [[nodiscard]] WidePoints at(Wide t) const {
    const WidePoints from = widen(x), motion = widen(step);
    WidePoints points;
    for (int a = 0; a < 4; ++a) points[a] = from[a] + t * motion[a];
    return points;
  }
  [[nodiscard]] double distance(Wide t) const {
    return static_cast<double>(reference_distance(kind, at(t)));
  }
  /// No two points of the primitives come nearer than this in one unit of time.
  [[nodiscard]] double speed() const {
    double most = 0;
    for_all_corners(kind, [&](int a, int b) { most = std::max(most, norm(step[a] - step[b])); });
    return most;
  }
  [[nodiscard]] double allowed(const StepLimits &limits = {}) const {
    return allowed_step(kind, x, step, limits);
  }
};

/// What holds of every answer: the step begins, the gap left is a tenth of the first one, and where
/// the step is cut the allowed approach is used up to a hundredth.
void expect_sound(const Moving &pair, double t) {
  const double start = pair.distance(0), least = 0.1 * start;
  ASSERT_GT(t, 0);
  ASSERT_LE(t, 1);
  ASSERT_GE(pair.distance(t), least * (1 - 1e-6));
  if (t < 1) {
    ASSERT_LE(pair.distance(t), least + 0.0101 * (start - least));
  }
}

/// Steps of no interest are cut short, others are the same to the last bit: the least of a list
/// does not depend on its order.
void expect_same_up_to_limits(const Moving &pair, double t) {
  for (const double share : {0.1, 0.5, 0.999}) {
    const double below = share * t, above = t + share * (1 - t);
    ASSERT_EQ(allowed_step(pair.kind, pair.x, pair.step, {}, below), below);
    ASSERT_EQ(allowed_step(pair.kind, pair.x, pair.step, {}, above), t < 1 ? t : 1);
  }
}

/// Pairs that touch at time k/8 exactly: made of integers from where they meet, at a point with
/// weights in eighths on each primitive, many of them on the border; motions of a few integers are
/// often parallel, coplanar or the same.
struct Impact {
  Moving pair;
  double time = 0;
};

Impact exact_impact(PairKind kind, std::mt19937 &random) {
  std::uniform_int_distribution<int> place(-5, 5), eighths(0, 8), motion(-3, 3), when(1, 8);
  const int dim = kind == PairKind::vertex_edge ? 2 : 3, k = when(random);
  const auto point = [&](auto &number, int factor) {
    Vector3 p;
    for (int i = 0; i < dim; ++i) p[i] = factor * number(random);
    return p;
  };
  PairPoints meeting;
  for (int a = 1; a < points_of_pair(kind); ++a) meeting[a] = point(place, 64);
  const int u = eighths(random), v = std::uniform_int_distribution<int>(0, 8 - u)(random);
  const auto between = [](const Vector3 &a, const Vector3 &b, int share) {
    return a + (share / 8.0) * (b - a);
  };
  if (kind == PairKind::edge_edge) {
    // x0 goes where the point of share u / 8 of its edge is the point of share v / 8 of the other:
    // x0 = p + s (p - x1) with the whole numbers s = 0, 1, 3, or it is an end.
    const Vector3 p = between(meeting[2], meeting[3], v);
    const int s = (u % 4) * (u % 4 + 1) / 2;
    meeting[0] = u == 8 ? meeting[0] : p + s * (p - meeting[1]);
    if (u == 8) meeting[1] = p;
  } else {
    meeting[0] = between(meeting[1], meeting[2], u);
    if (kind == PairKind::vertex_triangle) {
      meeting[0] = meeting[0] + (v / 8.0) * (meeting[3] - meeting[1]);
    }
  }
  Impact impact{{kind, {}, {}}, k / 8.0};
  for (int a = 0; a < points_of_pair(kind); ++a) {
    impact.pair.step[a] = point(motion, 64);
    impact.pair.x[a] = meeting[a] - impact.time * impact.pair.step[a];
  }
  return impact;
}

/// Never late: 1e5 pairs of each kind, from 1e-6 to 1e6 in size.
TEST(AllowedStep, StopsBeforeExactImpacts) {
  std::mt19937 random(1);
  for (const PairKind kind : all_kinds) {
    int apart = 0;
    for (int trial = 0; trial < 100000; ++trial) {
      Impact impact = exact_impact(kind, random);
      const double scale = std::ldexp(1.0, trial % 5 * 10 - 28);
      for (int a = 0; a < 4; ++a) {
        impact.pair.x[a] = scale * impact.pair.x[a];
        impact.pair.step[a] = scale * impact.pair.step[a];
      }
      const double t = impact.pair.allowed();
      if (impact.pair.distance(0) < 1e-15 * scale) {  // else it is a fraction of whole numbers
        ASSERT_EQ(t, 0);
        continue;
      }
      ++apart;
      ASSERT_GT(t, 0);
      ASSERT_LT(t, impact.time);
      if (trial % 20 == 0) {
        ASSERT_NO_FATAL_FAILURE(expect_sound(impact.pair, t)) << trial;
      }
    }
    EXPECT_GT(apart, 70000);
  }
}

/// The times in [0, 1] when the four points may lie in a plane (three of them on a line): roots of
/// the volume (area) in Bernstein's form, divided until its coefficients have one sign or the
/// interval is tiny.
void find_roots(const std::vector<Wide> &coefficients, Wide low, Wide high,
                std::vector<Wide> &roots) {
  const auto [least, most] = std::minmax_element(coefficients.begin(), coefficients.end());
  if (*least > 0 || *most < 0) return;
  if (high - low < 1e-10) {
    roots.push_back((low + high) / 2);
    return;
  }
  std::vector<Wide> left = {coefficients.front()}, right = {coefficients.back()},
                    row = coefficients;
  while (row.size() > 1) {
    for (std::size_t k = 0; k + 1 < row.size(); ++k) row[k] = (row[k] + row[k + 1]) / 2;
    row.pop_back();
    left.push_back(row.front());
    right.insert(right.begin(), row.back());
  }
  find_roots(left, low, (low + high) / 2, roots);
  find_roots(right, (low + high) / 2, high, roots);
}

std::vector<Wide> flat_times(const Moving &pair) {
  const bool plane = pair.kind == PairKind::vertex_edge;
  const auto volume = [&](Wide t) {
    const WidePoints p = pair.at(t);
    const WideVector product = cross(p[1] - p[0], p[2] - p[0]);
    return plane ? product[2] : dot(product, p[3] - p[0]);
  };
  // Power form from values at 0, 1, -1, 2, then Bernstein's.
  const Wide f0 = volume(0), f1 = volume(1), fm = volume(-1), f2 = volume(2);
  std::vector<Wide> roots;
  if (plane) {
    const Wide c2 = (f1 + fm) / 2 - f0, c1 = f1 - f0 - c2;
    find_roots({f0, f0 + c1 / 2, f1}, 0, 1, roots);
  } else {
    const Wide c2 = (f1 + fm) / 2 - f0, odd = (f1 - fm) / 2;
    const Wide c3 = (f2 - f0 - 4 * c2 - 2 * odd) / 6, c1 = odd - c3;
    find_roots({f0, f0 + c1 / 3, f0 + (2 * c1 + c2) / 3, f1}, 0, 1, roots);
  }
  return roots;
}

/// The first time when the two touch, by roots; 2: never.
double first_impact(const Moving &pair) {
  for (const Wide t : flat_times(pair)) {
    if (pair.distance(t) < 1e-9 * pair.speed()) return static_cast<double>(t);
  }
  return 2;
}

Moving random_moving(PairKind kind, std::mt19937 &random, double motion) {
  Moving pair{kind, random_points(kind, random), random_points(kind, random, motion)};
  return pair;
}

TEST(AllowedStep, StopsBeforeTheFirstRoot) {
  std::mt19937 random(2);
  for (const PairKind kind : all_kinds) {
    int impacts = 0;
    for (int trial = 0; trial < 3000; ++trial) {
      const Moving pair = random_moving(kind, random, std::pow(10, trial % 3 - 1));
      const double t = pair.allowed(), impact = first_impact(pair);
      ASSERT_LT(t, impact);
      ASSERT_NO_FATAL_FAILURE(expect_sound(pair, t)) << trial;
      ASSERT_NO_FATAL_FAILURE(expect_same_up_to_limits(pair, t));
      impacts += impact <= 1;
    }
    EXPECT_GT(impacts, 100);
  }
}

/// Gaps down to 1e-8 of the size, motions towards each other, along each other and apart.
TEST(AllowedStep, OfSmallGaps) {
  std::mt19937 random(3);
  for (const PairKind kind : all_kinds) {
    for (int trial = 0; trial < 3000; ++trial) {
      Moving pair = random_moving(kind, random, std::pow(10, -(trial % 7)));
      const NearestPoints nearest = nearest_points(kind, pair.x);
      const double gap = std::pow(10, -2 - trial % 7);
      for (int a = 0; a < points_of_first(kind); ++a) {
        pair.x[a] = pair.x[a] + (gap - nearest.distance) * nearest.normal;
      }
      const double t = pair.allowed();
      ASSERT_LT(t, first_impact(pair));
      ASSERT_NO_FATAL_FAILURE(expect_sound(pair, t)) << trial;
    }
  }
}

/// Between the ends too: marching with the Lipschitz bound of the distance, which steps over
/// nothing.
TEST(AllowedStep, KeepsTheGapAllAlong) {
  std::mt19937 random(4);
  int cut = 0;
  for (const PairKind kind : all_kinds) {
    for (int trial = 0; trial < 150; ++trial) {
      const Moving pair = random_moving(kind, random, 1);
      const double t = pair.allowed(), least = 0.099 * pair.distance(0), speed = pair.speed();
      double time = 0;
      while (time < t) {
        const double d = pair.distance(time);
        ASSERT_GT(d, 0.0999 * pair.distance(0));
        time += (d - least) / speed;
      }
      cut += t < 1;
    }
  }
  EXPECT_GT(cut, 50);
}

/// Head-on, the step is s of the way.
TEST(AllowedStep, HeadOn) {
  const PairPoints above{Vector3{0.3, 0.2, 2}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const PairPoints crossed{Vector3{-1, 0, 2}, {1, 0, 2}, {0.2, -1, 0}, {0.2, 1, 0}};
  const PairPoints plane{Vector3{0.3, 2, 0}, {0, 0, 0}, {1, 0, 0}, {}};
  const Moving falling[] = {
      {PairKind::vertex_triangle, above, {Vector3{0, 0, -4}, {}, {}, {}}},
      {PairKind::vertex_triangle, above, {Vector3{0, 0, -3}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}},
      {PairKind::edge_edge, crossed, {Vector3{0, 0, -4}, {0, 0, -4}, {}, {}}},
      {PairKind::edge_edge, crossed, {Vector3{5, 5, -4}, {5, 5, -4}, {5, 5, 0}, {5, 5, 0}}},
      {PairKind::vertex_edge, plane, {Vector3{0, -4, 0}, {}, {}, {}}}};
  for (const Moving &pair : falling) {
    EXPECT_NEAR(pair.allowed(), 0.9 * 0.5, 1e-14);
    EXPECT_NEAR(pair.allowed({0.5}), 0.5 * 0.5, 1e-14);
    // xi = 0.4 counts as the place to touch.
    EXPECT_NEAR(pair.allowed({0.9, 0.4}), 0.9 * 1.6 / 4, 1e-14);
    // Distances beyond 0.1 count as 0.1, so that 0.01 has to be left.
    EXPECT_NEAR(pair.allowed({0.9, 0, 0.1}), 1.99 / 4, 1e-14);
    EXPECT_EQ(pair.allowed({0.9, 2}), 0);
    EXPECT_EQ(pair.allowed({0.9, 3}), 0);
  }
}

TEST(AllowedStep, IsWholeWhereNothingComesNearer) {
  const PairPoints above{Vector3{0.3, 0.2, 1e-6}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const auto step_of = [&](const PairPoints &step) {
    return Moving{PairKind::vertex_triangle, above, step}.allowed();
  };
  const Vector3 far{1e3, -1e3, 1e3};
  EXPECT_EQ(step_of({}), 1);                                  // nothing moves
  EXPECT_EQ(step_of({far, far, far, far}), 1);                // all together
  EXPECT_EQ(step_of({Vector3{5, 7, 0}, {}, {}, {}}), 1);      // along the triangle
  EXPECT_EQ(step_of({Vector3{0.1, 0.1, 3}, {}, {}, {}}), 1);  // away from it
  EXPECT_EQ(step_of({Vector3{}, {0, 0, -1}, {2, 3, -1}, {0, 5, -1}}), 1);
}

/// A triangle that turns under a point at a tiny distance: the plane turns with it.
TEST(AllowedStep, OfATurn) {
  for (const double gap : {1e-2, 1e-5, 1e-8}) {
    for (const double angle : {0.1, 0.5, 1.2}) {
      const double c = std::cos(angle), s = std::sin(angle);
      const Vector3 foot{0.2, 0.1, 0};
      Moving pair{PairKind::vertex_triangle,
                  {foot + Vector3{0, 0, gap}, {-1, -1, 0}, {1, -1, 0}, {0, 1, 0}},
                  {}};
      for (int a = 0; a < 4; ++a) {
        const Vector3 r = pair.x[a] - foot;
        pair.step[a] = Vector3{c * r.x + s * r.z, r.y, -s * r.x + c * r.z} - r;
      }
      EXPECT_EQ(pair.allowed(), 1) << gap << ", " << angle;
    }
  }
}

/// A double root: the triangle's plane z = t x rises to a point that moves along x = 1 - t and
/// stays at z = 1/4: they touch at t = 1/2 and are apart again.
TEST(AllowedStep, OfAGrazingPoint) {
  const Moving grazing{PairKind::vertex_triangle,
                       {Vector3{1, 0, 0.25}, {0, -1, 0}, {0, 1, 0}, {2, 0, 0}},
                       {Vector3{-1, 0, 0}, {}, {}, {0, 0, 2}}};
  EXPECT_NEAR(grazing.distance(0.5), 0, 1e-15);
  EXPECT_LT(grazing.allowed(), 0.5);
  EXPECT_GT(grazing.allowed(), 0.3);
}

/// One edge falls on the end of another.
TEST(AllowedStep, OfEndsOfEdges) {
  const Moving end{PairKind::edge_edge,
                   {Vector3{-1, 0, 1}, {1, 0, 1}, {1, -1, 0}, {1, 1, 0}},
                   {Vector3{0, 0, -2}, {0, 0, -2}, {}, {}}};
  EXPECT_NEAR(end.allowed(), 0.45, 1e-14);
  Moving past = end;
  past.x[2].x = past.x[3].x = 1 + 1e-6;  // misses it by 1e-6, a gap that is not left
  EXPECT_NEAR(past.allowed(), 0.45, 1e-3);
}

/// Of a list, the least step of all, to the last bit, and the pair that has it.
TEST(AllowedStep, OfSurfaces) {
  std::mt19937 random(5);
  const Surface surface = two_sheets(12, 0.3, 0.01);
  const auto x = surface.rest_positions();
  std::normal_distribution<double> normal(0, 0.02);
  std::vector<double> step(x.size());
  for (double &s : step) s = normal(random);
  auto [pairs, share] = find_candidates(surface, x, step, {0.01});
  ASSERT_EQ(share, 1);
  const StepLimits limits{0.9, 1e-12};
  double least = 1;
  int holds = -1;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto vertices = vertices_of(surface, pairs[k]);
    const double t =
        allowed_step(pairs[k].kind, points_of(vertices, x), points_of(vertices, step), limits);
    if (t < least) {
      least = t;
      holds = static_cast<int>(k);
    }
  }
  const AllowedStep allowed = allowed_step(surface, pairs, x, step, limits);
  EXPECT_EQ(allowed.step, least);
  EXPECT_EQ(allowed.pair, holds);
  EXPECT_LT(least, 0.5);
  std::reverse(pairs.begin(), pairs.end());
  EXPECT_EQ(allowed_step(surface, pairs, x, step, limits).step, least);
  EXPECT_EQ(allowed_step(surface, {}, x, step, limits).step, 1);
  EXPECT_EQ(allowed_step(surface, pairs, x, step, limits, least / 2).step, least / 2);
  EXPECT_EQ(allowed_step(surface, pairs, x, step, limits, least / 2).pair, -1);
}

/// Wild steps, each as far as it is allowed: pairs come as near as a tenth of a tenth of ..., and
/// the exact check finds no intersection ever.
void expect_never_intersecting(const Surface &surface, const Vector3 &offset,
                               std::mt19937 &random) {
  const double diagonal = body_diagonal(surface);
  std::vector<double> x = surface.rest_positions(), step(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += offset[k % 3];
  ASSERT_TRUE(find_intersections(surface, x, {}).empty());
  std::normal_distribution<double> normal(0, 0.02 * diagonal);
  int cut = 0;
  for (int round = 0; round < 60; ++round) {
    for (std::size_t k = 0; k < step.size(); ++k) {
      if (surface.dim == 3 || k % 3 < 2) step[k] = normal(random);
    }
    const auto [pairs, share] = find_candidates(surface, x, step, {1e-3 * diagonal});
    const StepLimits limits{0.9, 1e-12 * diagonal};
    const AllowedStep allowed = allowed_step(surface, pairs, x, step, limits, share);
    ASSERT_GT(allowed.step, 0);
    cut += allowed.pair >= 0;
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += allowed.step * step[k];
    ASSERT_TRUE(find_intersections(surface, x, {}).empty()) << round;
  }
  EXPECT_GT(cut, 50);
}

TEST(AllowedStep, NothingEverIntersects) {
  std::mt19937 random(6);
  for (const Vector3 &offset : {Vector3{}, {1e3, -2e3, 3e3}}) {
    expect_never_intersecting(two_sheets(8, 0.3, 0.05), offset, random);
    // Without offset in the third direction of the plane.
    std::vector<SurfaceVertex> vertices;
    std::vector<SurfaceFacet> facets;
    for (int body = 0; body < 9; ++body) {
      for (int k = 0; k < 4; ++k) {
        const double x = 1.1 * (body % 3) + (k == 1 || k == 2), y = 1.1 * (body / 3) + (k > 1);
        vertices.push_back({{x, y, 0}, 0, body});
        facets.push_back({{4 * body + k, 4 * body + (k + 1) % 4, -1}, 1});
      }
    }
    expect_never_intersecting(make_surface(2, vertices, facets), {offset.x, offset.y, 0}, random);
  }
}

}  // namespace
}  // namespace trefoil::contact
