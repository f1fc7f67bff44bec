// Exact predicates against integers of 128 bits, and intersections of whole surfaces.
#include "contact/predicates.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "contact/intersections.hpp"
#include "contact_cases.hpp"
#include "contact_surfaces.hpp"

namespace trefoil::contact {
namespace {

__extension__ typedef __int128 Integer;
using IntegerPoint = std::array<std::int64_t, 3>;

int sign(Integer x) {
  return (x > 0) - (x < 0);
}

IntegerPoint minus(const IntegerPoint &a, const IntegerPoint &b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Integer volume(const IntegerPoint &a, const IntegerPoint &b, const IntegerPoint &c) {
  Integer sum = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    sum += Integer(a[i]) * (Integer(b[j]) * c[k] - Integer(b[k]) * c[j]);
  }
  return sum;
}

Vector3 scaled(const IntegerPoint &p, double scale) {
  return {scale * double(p[0]), scale * double(p[1]), scale * double(p[2])};
}

IntegerPoint random_point(std::mt19937_64 &random, std::int64_t bound) {
  std::uniform_int_distribution<std::int64_t> place(-bound, bound);
  return {place(random), place(random), place(random)};
}

/// Points of a plane, exactly and but for one, at all magnitudes.
TEST(Orientation, OfFourPoints) {
  std::mt19937_64 random(1);
  int zeros = 0;
  for (int trial = 0; trial < 100000; ++trial) {
    const std::int64_t bound = std::int64_t{1} << (2 + trial % 35);
    const IntegerPoint a = random_point(random, bound), b = random_point(random, bound),
                       c = random_point(random, bound);
    std::uniform_int_distribution<int> few(-2, 2), one(-1, 1);
    const int s = few(random), t = few(random);
    IntegerPoint d;
    for (int i = 0; i < 3; ++i) {
      d[i] = a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]) + (trial % 3 ? one(random) : 0);
    }
    const int expected = sign(volume(minus(b, a), minus(c, a), minus(d, a)));
    zeros += expected == 0;
    const double scale = std::ldexp(1.0, trial % 7 * 40 - 120);
    ASSERT_EQ(orientation(scaled(a, scale), scaled(b, scale), scaled(c, scale), scaled(d, scale)),
              expected);
    ASSERT_EQ(orientation(scaled(b, scale), scaled(a, scale), scaled(c, scale), scaled(d, scale)),
              -expected);
  }
  EXPECT_GT(zeros, 30000);
  EXPECT_LT(zeros, 70000);
}

TEST(Orientation, OfThreePoints) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 100000; ++trial) {
    const std::int64_t bound = std::int64_t{1} << (2 + trial % 45);
    const IntegerPoint a = random_point(random, bound), b = random_point(random, bound);
    std::uniform_int_distribution<int> few(-3, 3), one(-1, 1);
    const int s = few(random);
    IntegerPoint c;
    for (int i = 0; i < 3; ++i) c[i] = a[i] + s * (b[i] - a[i]) + (trial % 3 ? one(random) : 0);
    const double scale = std::ldexp(1.0, trial % 7 * 40 - 120);
    for (int dropped = 0; dropped < 3; ++dropped) {
      const int i = (dropped + 1) % 3, j = (dropped + 2) % 3;
      const Integer area =
          Integer(b[i] - a[i]) * (c[j] - a[j]) - Integer(b[j] - a[j]) * (c[i] - a[i]);
      ASSERT_EQ(orientation(scaled(a, scale), scaled(b, scale), scaled(c, scale), dropped),
                sign(area));
    }
  }
}

/// Points at a third of edges so long that their differences are rounded.
TEST(Orientation, OfThreePointsWithRoundedDifferences) {
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 20000; ++trial) {
    const IntegerPoint a = random_point(random, (std::int64_t{1} << 53) - 2);
    IntegerPoint b = random_point(random, (std::int64_t{1} << 53) - 2), c;
    for (int i = 0; i < 3; ++i) {
      b[i] -= (b[i] - a[i]) % 3;
      c[i] = a[i] + (b[i] - a[i]) / 3 + (trial % 3 == i);
    }
    for (int dropped = 0; dropped < 3; ++dropped) {
      const int i = (dropped + 1) % 3, j = (dropped + 2) % 3;
      const Integer area =
          Integer(b[i] - a[i]) * (c[j] - a[j]) - Integer(b[j] - a[j]) * (c[i] - a[i]);
      ASSERT_EQ(orientation(scaled(a, 1), scaled(b, 1), scaled(c, 1), dropped), sign(area));
    }
  }
}

/// Where the filter cannot decide: coordinates of very different magnitudes.
TEST(Orientation, OfMixedMagnitudes) {
  const double tiny = 1e-60;
  EXPECT_EQ(orientation({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e10, 1e10, tiny}), 1);
  EXPECT_EQ(orientation({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1e10, 1e10, -tiny}), -1);
  EXPECT_EQ(orientation({1, 1, 1}, {2, 1, 1}, {1, 2, 1}, {5, 7, 1}), 0);
  const double step = std::ldexp(1.0, -52);
  EXPECT_EQ(orientation({1, 1, 1}, {2, 1, 1}, {1, 2, 1}, {5, 7, 1 + step}), 1);
  EXPECT_EQ(orientation({0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}, {0.3, 0.3, 0.3}, {5, 7, 1}), 0);
}

/// By Cramer's rule: a + t (b - a) = c + u (d - c) + v (e - c); segments in the plane of the
/// triangle by distances.
Meeting reference_meeting(const std::array<IntegerPoint, 5> &p) {
  const auto &[a, b, c, d, e] = p;
  const IntegerPoint along = minus(b, a), u_edge = minus(d, c), v_edge = minus(e, c),
                     r = minus(a, c);
  const std::int64_t determinant = std::int64_t(-volume(along, u_edge, v_edge));
  if (determinant == 0) {
    const auto at = [&](int k) { return scaled(p[k], 1); };
    double least = INFINITY;
    for (int end = 0; end < 2; ++end) {
      least = std::min(least, double(reference_distance(PairKind::vertex_triangle,
                                                        widen({at(end), at(2), at(3), at(4)}))));
    }
    for (int k = 2; k < 5; ++k) {
      const PairPoints edges{at(0), at(1), at(k), at(k == 4 ? 2 : k + 1)};
      least = std::min(least, double(reference_distance(PairKind::edge_edge, widen(edges))));
    }
    return least < 1e-14 ? Meeting::touching : Meeting::apart;
  }
  const int s = determinant > 0 ? 1 : -1;
  const std::int64_t whole = s * determinant;
  const std::int64_t t = s * std::int64_t(volume(r, u_edge, v_edge));
  const std::int64_t u = s * std::int64_t(-volume(along, r, v_edge));
  const std::int64_t v = s * std::int64_t(-volume(along, u_edge, r));
  if (t < 0 || t > whole || u < 0 || v < 0 || u + v > whole) return Meeting::apart;
  const bool inside = t > 0 && t < whole && u > 0 && v > 0 && u + v < whole;
  return inside ? Meeting::crossing : Meeting::touching;
}

/// Small integers: every degenerate case is frequent.
TEST(Meeting, OfSegmentsAndTriangles) {
  std::mt19937 random(3);
  int seen[3] = {};
  for (int trial = 0; trial < 50000; ++trial) {
    std::uniform_int_distribution<int> place(0, 1 + trial % 4);
    std::array<IntegerPoint, 5> p;
    for (auto &point : p) point = {place(random), place(random), place(random)};
    const Meeting expected = reference_meeting(p);
    const auto at = [&](int k) { return scaled(p[k], 1); };
    ASSERT_EQ(segment_meets_triangle(at(0), at(1), at(2), at(3), at(4)), expected) << trial;
    ++seen[static_cast<int>(expected)];
  }
  for (const int count : seen) EXPECT_GT(count, 1000);
}

TEST(Meeting, OfSegmentsInThePlane) {
  std::mt19937 random(4);
  int seen[3] = {};
  for (int trial = 0; trial < 20000; ++trial) {
    std::uniform_int_distribution<int> place(0, 1 + trial % 5);
    PairPoints p;
    for (auto &point : p) point = {double(place(random)), double(place(random)), 0};
    const Meeting meeting = segments_meet(p[0], p[1], p[2], p[3]);
    const bool touch = double(reference_distance(PairKind::edge_edge, widen(p))) < 1e-14;
    ASSERT_EQ(meeting != Meeting::apart, touch) << trial;
    // They cross where a slight motion of any end does not change that they meet.
    if (touch) {
      bool firm = squared_norm(cross(p[1] - p[0], p[3] - p[2])) > 0;
      for (int k = 0; k < 4; ++k) {
        for (const Vector3 off :
             {Vector3{1e-6, 0, 0}, {-1e-6, 0, 0}, {0, 1e-6, 0}, {0, -1e-6, 0}}) {
          PairPoints moved = p;
          moved[k] = moved[k] + off;
          firm = firm && double(reference_distance(PairKind::edge_edge, widen(moved))) < 1e-14;
        }
      }
      ASSERT_EQ(meeting == Meeting::crossing, firm) << trial;
    }
    ++seen[static_cast<int>(meeting)];
  }
  for (const int count : seen) EXPECT_GT(count, 1000);
}

/// All edges against all facets.
std::vector<std::pair<int, int>> brute_force(const Surface &surface, const std::vector<double> &x) {
  std::vector<std::pair<int, int>> met;
  for (int e = 0; e < surface.edge_count(); ++e) {
    for (int f = 0; f < surface.facet_count(); ++f) {
      const auto &edge = surface.edges[e];
      const auto &facet = surface.facets[f];
      if (std::any_of(facet.begin(), facet.end(),
                      [&](int v) { return v == edge[0] || v == edge[1]; }))
        continue;
      if (joint_role(surface.edge_data[e], surface.facet_data[f]) != Role::free) continue;
      const auto at = [&](int v) { return point_of(x, v); };
      if (segment_meets_triangle(at(edge[0]), at(edge[1]), at(facet[0]), at(facet[1]),
                                 at(facet[2])) != Meeting::apart) {
        met.emplace_back(e, f);
      }
    }
  }
  return met;
}

TEST(Intersections, OfCrowds) {
  std::mt19937 random(5);
  for (const bool obstacles : {false, true}) {
    const Surface surface = tetrahedra(20, 0.2, 1, random, 3, obstacles);
    const auto x = surface.rest_positions();
    std::vector<std::pair<int, int>> found;
    for (const Intersection &i : find_intersections(surface, x, {})) {
      found.emplace_back(i.edge, i.facet);
      const auto &edge = surface.edges[i.edge];
      const auto &facet = surface.facets[i.facet];
      for (const PairPoints &p : {PairPoints{i.place, point_of(x, facet[0]), point_of(x, facet[1]),
                                             point_of(x, facet[2])},
                                  PairPoints{i.place, point_of(x, edge[0]), point_of(x, edge[1]),
                                             point_of(x, edge[1])}}) {
        EXPECT_LT(nearest_points(PairKind::vertex_triangle, p).distance, 1e-13);
      }
    }
    EXPECT_EQ(found, brute_force(surface, x));
    EXPECT_GT(found.size(), 10U);
    std::size_t by_ranks = 0;
    for (int rank = 0; rank < 3; ++rank) {
      by_ranks += find_intersections(surface, x, {0, true, false, rank}).size();
    }
    EXPECT_EQ(by_ranks, found.size());
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
  }
}

TEST(Intersections, OfSheets) {
  const Surface apart = two_sheets(10, 0.3, 1e-9), together = two_sheets(10, 0.3, 0);
  EXPECT_TRUE(find_intersections(apart, apart.rest_positions(), {}).empty());
  const auto touching = find_intersections(together, together.rest_positions(), {});
  EXPECT_GT(touching.size(), 200U);
  for (const Intersection &i : touching) EXPECT_EQ(i.meeting, Meeting::touching);
  // One vertex of the upper sheet pushed through the lower one.
  Surface pierced = two_sheets(10, 0.3, 0.01);
  pierced.vertices[121 + 60].rest.z = -0.001;
  const auto pierced_by = find_intersections(pierced, pierced.rest_positions(), {});
  EXPECT_GT(pierced_by.size(), 3U);
  for (const Intersection &i : pierced_by) EXPECT_EQ(i.meeting, Meeting::crossing);
  EXPECT_TRUE(find_intersections(pierced, pierced.rest_positions(), {0, true, false, 7}).empty());
}

TEST(Intersections, SelfContactCanBeLeftOut) {
  Surface surface = two_sheets(10, 0.3, 0.01);
  for (Primitive &p : surface.edge_data) p.body = 0;
  for (Primitive &p : surface.facet_data) p.body = 0;
  auto x = surface.rest_positions();
  x[3 * (121 + 60) + 2] = -1;
  EXPECT_FALSE(find_intersections(surface, x, {}).empty());
  EXPECT_TRUE(find_intersections(surface, x, {0, false}).empty());
}

TEST(Intersections, InThePlane) {
  const auto squares = [](double shift) {
    std::vector<SurfaceVertex> vertices;
    std::vector<SurfaceFacet> facets;
    for (int body = 0; body < 2; ++body) {
      for (int k = 0; k < 4; ++k) {
        const double x = (k == 1 || k == 2) + shift * body, y = (k > 1) + 0.25 * body;
        vertices.push_back({{x, y, 0}, 0, body});
        facets.push_back({{4 * body + k, 4 * body + (k + 1) % 4, -1}, 1});
      }
    }
    return make_surface(2, vertices, facets);
  };
  const auto meetings = [&](double shift) {
    const Surface surface = squares(shift);
    return find_intersections(surface, surface.rest_positions(), {});
  };
  EXPECT_TRUE(meetings(1.5).empty());
  const auto touching = meetings(1);
  EXPECT_EQ(touching.size(), 3U);  // side on side, and the ends of two others on them
  for (const Intersection &i : touching) EXPECT_EQ(i.meeting, Meeting::touching);
  const auto crossing = meetings(0.5);
  ASSERT_EQ(crossing.size(), 2U);
  for (const Intersection &i : crossing) EXPECT_EQ(i.meeting, Meeting::crossing);
  EXPECT_NEAR(
      norm(crossing[0].place - Vector3{1, 0.25, 0}) * norm(crossing[0].place - Vector3{0.5, 1, 0}),
      0, 1e-15);
}

}  // namespace
}  // namespace trefoil::contact
