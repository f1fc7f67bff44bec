// The broad phase against all pairs: boxes of all sizes, swept surfaces, and what ranks own.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "contact/candidate_list.hpp"
#include "contact/candidates.hpp"
#include "contact/separation.hpp"
#include "contact/sorted_grid.hpp"
#include "contact_cases.hpp"
#include "contact_surfaces.hpp"

namespace trefoil::contact {
namespace {

/// By how much two boxes miss each other; negative or zero: they overlap.
double miss(const Box &a, const Box &b) {
  double most = -INFINITY;
  for (int i = 0; i < 3; ++i) {
    most = std::max({most, a.low[i] - b.high[i], b.low[i] - a.high[i]});
  }
  return most;
}

double extent(const std::vector<Box> &boxes) {
  Box all = boxes[0];
  for (const Box &box : boxes) {
    for (int i = 0; i < 3; ++i) {
      all.low[i] = std::min(all.low[i], box.low[i]);
      all.high[i] = std::max(all.high[i], box.high[i]);
    }
  }
  const Vector3 side = all.high - all.low;
  return std::max({side.x, side.y, side.z});
}

/// Every overlapping pair once, and nothing that misses by more than rounding in single precision.
void expect_all_pairs(const std::vector<Box> &first, const std::vector<Box> &second) {
  std::map<std::pair<int, int>, int> found;
  const bool one_set = second.empty();
  const auto count = [&](int a, int b) { ++found[{a, b}]; };
  if (one_set) {
    SortedGrid(first).visit_pairs(count);
  } else {
    SortedGrid(first, second).visit_pairs(count);
  }
  const auto &others = one_set ? first : second;
  std::vector<Box> all = first;
  all.insert(all.end(), second.begin(), second.end());
  const double tolerance = 3e-6 * extent(all);
  for (int a = 0; a < static_cast<int>(first.size()); ++a) {
    for (int b = one_set ? a + 1 : 0; b < static_cast<int>(others.size()); ++b) {
      const double distance = miss(first[a], others[b]);
      const auto pair = found.find({a, b});
      const int times = pair == found.end() ? 0 : pair->second;
      if (distance <= 0) {
        ASSERT_EQ(times, 1) << a << ", " << b;
      } else if (distance > tolerance) {
        ASSERT_EQ(times, 0) << a << ", " << b;
      } else {
        ASSERT_LE(times, 1);
      }
      if (pair != found.end()) found.erase(pair);
    }
  }
  EXPECT_TRUE(found.empty()) << "pairs of no boxes";
}

void expect_all_pairs(const std::vector<Box> &boxes) {
  expect_all_pairs(boxes, {});
  const auto middle = boxes.begin() + static_cast<std::ptrdiff_t>(boxes.size() / 3);
  expect_all_pairs({boxes.begin(), middle}, {middle, boxes.end()});
}

template <class Side>
std::vector<Box> random_boxes(int count, std::mt19937 &random, const Side &side,
                              const Vector3 &space = {1, 1, 1}) {
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<Box> boxes(count);
  for (Box &box : boxes) {
    for (int i = 0; i < 3; ++i) {
      box.low[i] = space[i] * place(random);
      box.high[i] = box.low[i] + side();
    }
  }
  return boxes;
}

TEST(SortedGrid, RandomBoxes) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const double side : {0.01, 0.1, 0.5, 2.0}) {
    expect_all_pairs(random_boxes(700, random, [&] { return side * unit(random); }));
  }
}

TEST(SortedGrid, SizesFromAMillionthToTheWhole) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> power(-6, 0);
  expect_all_pairs(random_boxes(1200, random, [&] { return std::pow(10, power(random)); }));
}

TEST(SortedGrid, AFloorUnderManySmallBoxes) {
  std::mt19937 random(3);
  auto boxes = random_boxes(1500, random, [] { return 0.01; });
  boxes.push_back({{-100, -100, 0.2}, {100, 100, 0.2}});
  boxes.push_back({{-100, -100, 0.9}, {100, 100, 0.91}});
  boxes.push_back({{-1e5, 0, 0}, {1e5, 1e5, 1}});
  expect_all_pairs(boxes);
}

TEST(SortedGrid, FlatBoxesPointsAndLines) {
  std::mt19937 random(4);
  expect_all_pairs(random_boxes(300, random, [] { return 0.0; }));             // points
  expect_all_pairs(random_boxes(300, random, [] { return 0.0; }, {1, 0, 0}));  // of a line
  expect_all_pairs(random_boxes(300, random, [] { return 0.0; }, {0, 0, 0}));  // all the same
  expect_all_pairs(random_boxes(500, random, [] { return 0.05; }, {1, 1, 0}));
  expect_all_pairs(random_boxes(500, random, [] { return 0.05; }, {0, 50, 0}));
}

/// Sides that touch count: a lattice of boxes that share their sides, also far from the origin.
TEST(SortedGrid, BoxesThatTouch) {
  for (const double offset : {0.0, -1e6}) {
    std::vector<Box> boxes;
    for (int k = 0; k < 512; ++k) {
      const Vector3 low{offset + k % 8, offset + k / 8 % 8, offset + k / 64};
      boxes.push_back({low, low + Vector3{1, 1, 1}});
    }
    expect_all_pairs(boxes);
  }
}

/// At places that are no round numbers, where rounding to the nearest would tear some apart.
TEST(SortedGrid, BoxesThatTouchAnywhere) {
  std::mt19937 random(10);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Box> boxes;
  Vector3 low{unit(random), 0, 0};
  for (int k = 0; k < 1000; ++k) {
    const Vector3 high = low + Vector3{unit(random), 0.7, 0.1 * (k % 2)};
    boxes.push_back({low, high});
    low.x = high.x;
  }
  expect_all_pairs(boxes);
}

TEST(SortedGrid, ScatteredBodies) {
  std::mt19937 random(5);
  std::vector<Box> boxes;
  for (int body = 0; body < 20; ++body) {
    auto some = random_boxes(40, random, [] { return 0.02; }, {0.2, 0.2, 0.2});
    const Vector3 shift{1e4 * std::cos(body), 1e5 * std::sin(body), 1e3 * body};
    for (Box &box : some) boxes.push_back({box.low + shift, box.high + shift});
  }
  expect_all_pairs(boxes);
}

TEST(SortedGrid, NoBoxes) {
  const auto none = [](int, int) { FAIL(); };
  SortedGrid(std::vector<Box>{}).visit_pairs(none);
  SortedGrid({}, {Box{}}).visit_pairs(none);
  SortedGrid({Box{}}, {}).visit_pairs(none);
  SortedGrid({Box{}}).visit_pairs(none);
}

/// All pairs of a kind.
std::vector<ContactPair> all_pairs(const Surface &surface, const PairSearch &search) {
  std::vector<ContactPair> pairs;
  const PairKind with_facet = surface.dim == 3 ? PairKind::vertex_triangle : PairKind::vertex_edge;
  for (int v = 0; v < surface.vertex_count(); ++v) {
    for (int f = 0; f < surface.facet_count(); ++f) pairs.push_back({with_facet, v, f});
  }
  for (int a = 0; a < surface.edge_count() && surface.dim == 3; ++a) {
    for (int b = a + 1; b < surface.edge_count(); ++b) {
      pairs.push_back({PairKind::edge_edge, a, b});
    }
  }
  std::erase_if(pairs, [&](const ContactPair &p) { return !may_touch(surface, p, search); });
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

/// The least distance on a number of places of the step.
double least_distance(const Surface &surface, const ContactPair &pair, const std::vector<double> &x,
                      const std::vector<double> &step) {
  const auto vertices = vertices_of(surface, pair);
  const PairPoints from = points_of(vertices, x), motion = points_of(vertices, step);
  double least = INFINITY;
  for (int k = 0; k <= 20; ++k) {
    least = std::min(least, nearest_points(pair.kind, moved(from, motion, k / 20.)).distance);
  }
  return least;
}

/// Nothing that comes near is missing; at rest nothing else is there.
void expect_candidates(const Surface &surface, double step_size, const PairSearch &search,
                       std::mt19937 &random) {
  std::normal_distribution<double> normal(0, step_size);
  const std::vector<double> x = surface.rest_positions();
  std::vector<double> step(x.size());
  for (std::size_t k = 0; k < step.size(); ++k) {
    if (surface.dim == 3 || k % 3 < 2) step[k] = normal(random);
  }
  const auto [found, share] = find_candidates(surface, x, step, search);
  EXPECT_EQ(share, 1);
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
  const std::set<ContactPair> candidates(found.begin(), found.end());
  std::size_t near = 0, may = 0;
  for (const ContactPair &pair : all_pairs(surface, search)) {
    ++may;
    if (least_distance(surface, pair, x, step) >= search.reach) continue;
    ++near;
    ASSERT_TRUE(candidates.count(pair)) << pair.first << ", " << pair.second;
  }
  EXPECT_GT(near, 20U);
  EXPECT_LT(found.size(), may);

  const auto at_rest = find_candidates(surface, x, search);
  std::vector<ContactPair> expected = all_pairs(surface, search);
  std::erase_if(expected, [&](const ContactPair &pair) {
    const auto points = points_of(vertices_of(surface, pair), x);
    return nearest_points(pair.kind, points).distance > search.reach;
  });
  EXPECT_EQ(at_rest, expected);
}

TEST(Candidates, OfBodiesThatMove) {
  std::mt19937 random(6);
  for (const double step : {0.001, 0.05, 0.4, 3.0}) {
    for (const bool self : {true, false}) {
      PairSearch search{0.05, self};
      expect_candidates(tetrahedra(15, 0.15, 1, random), step, search, random);
      expect_candidates(polygons(15, 0.1, 1, random), step, search, random);
    }
  }
}

TEST(Candidates, OfCurvedSheetsWithSelfContact) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.02);
  Surface surface = two_sheets(6, 0.3, 0.08);
  for (SurfaceVertex &v : surface.vertices) {
    v.rest = {v.rest.x, v.rest.y + 0.3 * v.rest.x * v.rest.x, v.rest.z + noise(random)};
  }
  expect_candidates(surface, 0.02, {0.06}, random);
  expect_candidates(surface, 0.02, {0.2, true}, random);
}

TEST(Candidates, RolesDecide) {
  std::mt19937 random(8);
  const Surface surface = tetrahedra(20, 0.2, 1, random, 1, true);
  const auto x = surface.rest_positions();
  PairSearch search{0.2};
  for (const bool prescribed : {false, true}) {
    search.prescribed = prescribed;
    expect_candidates(surface, 0.05, search, random);
    std::set<Role> seen;
    for (const ContactPair &pair : find_candidates(surface, x, search)) {
      seen.insert(joint_role(first_of(surface, pair), second_of(surface, pair)));
    }
    EXPECT_EQ(seen, prescribed ? (std::set{Role::free, Role::prescribed}) : std::set{Role::free});
  }
}

/// Ranks share the pairs out: each has exactly one owner, whatever the number of ranks.
TEST(Candidates, RanksShareThemOut) {
  for (const int ranks : {1, 2, 4}) {
    std::mt19937 random(9);
    const Surface surface = tetrahedra(25, 0.2, 1, random, ranks, true);
    const auto x = surface.rest_positions();
    std::normal_distribution<double> normal(0, 0.05);
    std::vector<double> step(x.size());
    for (double &s : step) s = normal(random);
    std::vector<ContactPair> together;
    for (int rank = 0; rank < ranks + 1; ++rank) {  // the last one owns nothing
      const auto own = find_candidates(surface, x, step, {0.1, true, false, rank}).pairs;
      for (const ContactPair &pair : own) {
        EXPECT_EQ(owner_of_pair(first_of(surface, pair), second_of(surface, pair)), rank);
      }
      together.insert(together.end(), own.begin(), own.end());
    }
    std::sort(together.begin(), together.end());
    EXPECT_EQ(together, find_candidates(surface, x, step, {0.1}).pairs);
    EXPECT_GT(together.size(), 500U);
  }
}

/// The last vertex of a tetrahedron belongs to a rank that owns nothing else, no edge or facet.
TEST(Candidates, OfARankWithOneVertex) {
  std::mt19937 random(11);
  Surface surface = tetrahedra(2, 0.3, 0.1, random);
  surface.vertices[3].owner = surface.vertex_data[3].owner = 1;
  std::vector<ContactPair> expected = find_candidates(surface, surface.rest_positions(), {0.5});
  std::erase_if(expected, [](const ContactPair &pair) {
    return pair.kind != PairKind::vertex_triangle || pair.first != 3;
  });
  ASSERT_GT(expected.size(), 1U);
  EXPECT_EQ(find_candidates(surface, surface.rest_positions(), {0.5, true, false, 1}), expected);
}

/// Steps that sweep everything: a share of them, quickly, and a complete list for that share.
TEST(Candidates, OfWildSteps) {
  std::mt19937 random(12);
  const Surface surface = two_sheets(24, 0.3, 0.02);
  const auto x = surface.rest_positions();
  std::vector<double> step(x.size());
  std::normal_distribution<double> normal;
  double before = 1;
  for (const double size : {1e-3, 1.0, 1e3, 1e9}) {
    for (double &s : step) s = size * normal(random);
    const SweptCandidates found = find_candidates(surface, x, step, {0.01});
    EXPECT_LE(found.share, before);
    EXPECT_GE(found.share * size, 1e-3);
    before = found.share;
    // The same as for the share as a step of its own.
    std::vector<double> part = step;
    for (double &s : part) s *= found.share;
    const SweptCandidates of_part = find_candidates(surface, x, part, {0.01});
    EXPECT_EQ(of_part.share, 1);
    EXPECT_EQ(of_part.pairs, found.pairs);
  }
  EXPECT_LT(before, 1e-9);
  // What all vertices do together is no motion.
  for (std::size_t k = 0; k < step.size(); ++k) step[k] = k % 3 == 0 ? 1e6 : 0;
  EXPECT_EQ(find_candidates(surface, x, step, {0.01}).share, 1);
  step[7] = std::nan("");
  EXPECT_EQ(find_candidates(surface, x, step, {0.01}).share, 0);
}

/// Where a list says that it serves, it has all pairs that are there.
TEST(CandidateList, CoversWhatItSays) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 1);
  const Surface surface = tetrahedra(40, 0.3, 2, random);
  const std::vector<double> x = surface.rest_positions();
  const PairSearch search{0.1};
  std::vector<double> step(x.size()), moved(x.size());
  for (double &s : step) s = 0.2 * normal(random);
  CandidateList around, along;
  EXPECT_FALSE(around.covers(x));
  around.find(surface, x, search);
  along.find(surface, x, step, search);
  int covered[2] = {0, 0};
  const auto check = [&](const CandidateList &list, int &count) {
    if (!list.covers(moved)) return;
    ++count;
    const auto there = find_candidates(surface, moved, search);
    EXPECT_TRUE(
        std::includes(list.pairs().begin(), list.pairs().end(), there.begin(), there.end()));
  };
  for (int k = 0; k < 40; ++k) {
    const double t = -0.1 + 1.2 * k / 39, off = k % 3 ? 0 : 1e-2 * normal(random);
    for (std::size_t i = 0; i < x.size(); ++i) {
      moved[i] = x[i] + t * step[i] + (i % 3 == 0 ? off : 0);
    }
    check(along, covered[0]);
    for (std::size_t i = 0; i < x.size(); ++i) moved[i] = x[i] + 0.02 * normal(random);
    check(around, covered[1]);
  }
  EXPECT_GT(covered[0], 15);
  EXPECT_LT(covered[0], 35);  // beyond its ends and beside it there is none
  for (std::size_t i = 0; i < x.size(); ++i) moved[i] = x[i] + (i % 3 == 0 ? 0.06 : 0);
  EXPECT_FALSE(around.covers(moved));
  for (std::size_t i = 0; i < x.size(); ++i) moved[i] = x[i] + (i % 3 == 0 ? 0.04 : 0);
  EXPECT_TRUE(around.covers(moved));
}

TEST(Candidates, NothingThere) {
  const Surface nothing = make_surface(3, {}, {});
  EXPECT_TRUE(find_candidates(nothing, {}, {1}).empty());
  EXPECT_TRUE(find_candidates(nothing, {}, {}, {1}).pairs.empty());
}

}  // namespace
}  // namespace trefoil::contact
