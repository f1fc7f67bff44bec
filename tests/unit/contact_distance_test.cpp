// Distances and their derivatives against quadruple precision: by projection, and by differences.
#include "contact/barrier.hpp"
#include "contact/pair_derivatives.hpp"
#include "contact_cases.hpp"
#include "filter/filter.hpp"

namespace trefoil::contact {
namespace {

double reference(PairKind kind, const PairPoints &x) {
  return static_cast<double>(reference_distance(kind, widen(x)));
}

double size_of(const PairPoints &x) {
  double size = 0;
  for (const Vector3 &p : x) size = std::max(size, norm(p - x[0]));
  return size;
}

/// The distance within eps times the size, points inside their primitives, normal and weights that
/// say the same.
void expect_right(PairKind kind, const PairPoints &x) {
  const NearestPoints nearest = nearest_points(kind, x);
  const double size = size_of(x), d = reference(kind, x);
  EXPECT_NEAR(nearest.distance, d, 4e-15 * size);
  Vector3 r;
  double sum = 0;
  for (int a = 0; a < 4; ++a) {
    r = r + nearest.weights[a] * (x[a] - x[0]);
    sum += nearest.weights[a];
    const bool first = a < points_of_first(kind);
    EXPECT_GE(first ? nearest.weights[a] : -nearest.weights[a], -1e-15);
  }
  EXPECT_NEAR(sum, 0, 1e-15);
  EXPECT_NEAR(norm(r - nearest.distance * nearest.normal), 0,
              (nearest.distance > 1e-6 * size ? 1e-8 : 1) * nearest.distance + 1e-14 * size);
  if (nearest.distance > 1e-14 * size) {
    EXPECT_NEAR(norm(nearest.normal), 1, 1e-14);
  }
}

TEST(Distance, OfRandomPairsOfEveryClass) {
  std::mt19937 random(1);
  for (const PairKind kind : all_kinds) {
    for (const Nearest nearest : classes_of(kind)) {
      for (int trial = 0; trial < 2000; ++trial) {
        expect_right(kind, random_points_of(kind, nearest, random));
      }
    }
  }
}

TEST(Distance, OfPairsNearEachOtherFarFromTheOrigin) {
  std::mt19937 random(2);
  for (const PairKind kind : all_kinds) {
    for (int trial = 0; trial < 2000; ++trial) {
      const double gap = std::pow(10, -1 - trial % 8);
      PairPoints x = random_points(kind, random, 1, {100, -200, kind == all_kinds[2] ? 0. : 50.});
      const NearestPoints nearest = nearest_points(kind, x);
      const Vector3 approach = (gap - nearest.distance) * nearest.normal;
      for (int a = 0; a < points_of_first(kind); ++a) x[a] = x[a] + approach;
      const NearestPoints near = nearest_points(kind, x);
      const double d = reference(kind, x);
      EXPECT_NEAR(near.distance, d, 4e-15 * size_of(x)) << "gap " << gap;
      EXPECT_NEAR(dot(near.normal, nearest.normal), 1, 1e-6);
    }
  }
}

/// Integer coordinates: parallel, collinear, coincident and touching pairs are frequent.
TEST(Distance, OfDegeneratePairs) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> digit(0, 2);
  for (const PairKind kind : all_kinds) {
    for (int trial = 0; trial < 20000; ++trial) {
      PairPoints x;
      for (int a = 0; a < points_of_pair(kind); ++a) {
        for (int i = 0; i < (kind == PairKind::vertex_edge ? 2 : 3); ++i) x[a][i] = digit(random);
      }
      const NearestPoints nearest = nearest_points(kind, x);
      ASSERT_NEAR(nearest.distance, reference(kind, x), 1e-14);
    }
  }
}

/// Edges that are parallel up to 1e-16, triangles down to a height of 1e-16.
TEST(Distance, OfNearlyDegeneratePairs) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (const PairKind kind : {PairKind::vertex_triangle, PairKind::edge_edge}) {
    for (int trial = 0; trial < 20000; ++trial) {
      const double slope = std::pow(10, -1 - trial % 17), gap = std::pow(10, -(trial / 17) % 6);
      PairPoints x = random_points(kind, random);
      const Vector3 along = x[1] - x[0], off{normal(random), normal(random), normal(random)};
      if (kind == PairKind::edge_edge) {
        x[2] = x[0] + normal(random) * along + gap * off;
        x[3] = x[2] + normal(random) * along + slope * random_points(kind, random)[0];
      } else {
        const double t = normal(random);
        x[3] = x[1] + t * (x[2] - x[1]) + slope * off;
        x[0] = x[1] + normal(random) * (x[2] - x[1]) + gap * random_points(kind, random)[0];
      }
      ASSERT_NEAR(nearest_points(kind, x).distance, reference(kind, x), 2e-14 * size_of(x))
          << "slope " << slope << ", gap " << gap;
    }
  }
}

/// A function with negative slope and positive curvature, as a barrier has.
constexpr double dhat = 4;
template <class Real>
Real potential(Real d) {
  return dhat * (1 - d / dhat) * (1 - d / dhat) * (dhat / d);
}
Barrier potential_and_derivatives(double d) {
  // dhat^2 / d - 2 dhat + d
  return {potential(d), 1 - dhat * dhat / (d * d), 2 * dhat * dhat / (d * d * d)};
}

/// m(x) b(d(x)).
Wide reference_energy(PairKind kind, const WidePoints &x, double threshold) {
  Wide m = 1;
  if (kind == PairKind::edge_edge) {
    const WideVector product = cross(x[1] - x[0], x[3] - x[2]);
    const Wide s = dot(product, product) / threshold;
    if (s < 1) m = (2 - s) * s;
  }
  return m * potential(reference_distance(kind, x));
}

PairFrame frame_of(PairKind kind, const PairPoints &x, double threshold) {
  const NearestPoints nearest = nearest_points(kind, x);
  const Mollifier m = kind == PairKind::edge_edge ? mollifier(x, threshold) : Mollifier{};
  return pair_frame(x, kind == PairKind::vertex_edge ? 2 : 3, nearest,
                    potential_and_derivatives(nearest.distance), m);
}

/// Gradient and Hessian against central differences with a step of h times the distance. In the
/// plane the third direction is left out.
void expect_derivatives(PairKind kind, const PairPoints &x, double threshold, double h = 1e-9) {
  const PairFrame frame = frame_of(kind, x, threshold);
  const auto gradient = pair_gradient(frame);
  std::array<double, 144> H;
  pair_hessian(frame, H.data());
  double largest_g = 0, largest_h = 0;
  for (const double g : gradient) largest_g = std::max(largest_g, std::abs(g));
  for (const double entry : H) largest_h = std::max(largest_h, std::abs(entry));

  const int dim = kind == PairKind::vertex_edge ? 2 : 3;
  const double step = h * frame.distance;
  const auto energy = [&](int i, double di, int j, double dj) {
    WidePoints moved = widen(x);
    moved[i / 3][i % 3] += di;
    moved[j / 3][j % 3] += dj;
    return reference_energy(kind, moved, threshold);
  };
  for (int i = 0; i < 12; ++i) {
    if (i % 3 >= dim) continue;
    const Wide slope = (energy(i, step, i, 0) - energy(i, -step, i, 0)) / (2 * Wide(step));
    EXPECT_NEAR(gradient[i], static_cast<double>(slope), 1e-11 * largest_g) << "entry " << i;
    for (int j = 0; j <= i; ++j) {
      if (j % 3 >= dim) continue;
      const Wide second = (energy(i, step, j, step) - energy(i, step, j, -step) -
                           energy(i, -step, j, step) + energy(i, -step, j, -step)) /
                          (4 * Wide(step) * step);
      EXPECT_NEAR(H[12 * i + j], static_cast<double>(second), 1e-9 * largest_h)
          << "entry " << i << ", " << j;
      EXPECT_EQ(H[12 * i + j], H[12 * j + i]);
    }
  }
}

constexpr double never = 1e-300;  // a threshold that no pair is below

TEST(PairDerivatives, OfEveryClass) {
  std::mt19937 random(5);
  for (const PairKind kind : all_kinds) {
    for (const Nearest nearest : classes_of(kind)) {
      for (int trial = 0; trial < 50; ++trial) {
        expect_derivatives(kind, random_points_of(kind, nearest, random), never);
      }
    }
  }
}

TEST(PairDerivatives, OfTheMollifierOfEveryClass) {
  std::mt19937 random(6);
  for (const Nearest nearest : classes_of(PairKind::edge_edge)) {
    for (int trial = 0; trial < 50; ++trial) {
      const PairPoints x = random_points_of(PairKind::edge_edge, nearest, random);
      const double c = squared_norm(cross(x[1] - x[0], x[3] - x[2]));
      for (const double share : {0.01, 0.5, 0.999, 1.001, 3.0}) {
        expect_derivatives(PairKind::edge_edge, x, c / share);
      }
    }
  }
}

/// Two edges in parallel planes a unit apart, at an angle.
PairPoints crossed_edges(double angle, double shift = 0) {
  const Vector3 along{std::cos(angle), std::sin(angle), 0}, middle{shift, 0, 1};
  return {Vector3{-1, 0, 0}, Vector3{1, 0, 0}, middle - along, middle + along};
}

TEST(PairDerivatives, OfNearlyParallelEdges) {
  const double threshold = mollifier_threshold({2, 0, 0}, {2, 0, 0});
  for (const double angle : {0.03, 1e-2, 1e-3, 1e-4}) {
    expect_derivatives(PairKind::edge_edge, crossed_edges(angle), threshold);
    expect_derivatives(PairKind::edge_edge, crossed_edges(angle, 1.5), threshold);
  }
}

TEST(PairDerivatives, OfParallelEdgesAreThoseOfTheMollifierAlone) {
  // There d jumps in its slope, but m and grad m are zero: hess = b hess m.
  const double threshold = mollifier_threshold({2, 0, 0}, {2, 0, 0});
  const PairFrame frame = frame_of(PairKind::edge_edge, crossed_edges(0), threshold);
  for (const double g : pair_gradient(frame)) EXPECT_EQ(g, 0);
  std::array<double, 144> H;
  pair_hessian(frame, H.data());
  // c = |a x b|^2 grows by |a|^2 (b_y^2 + b_z^2), and dm/dc = 2 / threshold at 0: with a = 2, and
  // b_y the y of x3 - x2, d2m/dy3^2 = 2 |a|^2 2 / threshold.
  EXPECT_NEAR(H[12 * 10 + 10], potential(1.0) * 2 * 4 * 2 / threshold, 1e-9 * H[12 * 10 + 10]);
}

/// Along a path through all classes, the gradient has no jump, and on both sides of a change of
/// class it is the right one.
void expect_continuous(PairKind kind, const PairPoints &x, int moving, const Vector3 &motion,
                       double threshold, int changes) {
  constexpr int steps = 400;
  constexpr double tiny = 1e-9;
  const auto at = [&](double t) {
    PairPoints y = x;
    y[moving] = x[moving] + t * motion;
    return y;
  };
  int found = 0;
  for (int step = 0; step < steps; ++step) {
    double low = step / double{steps}, high = (step + 1) / double{steps};
    const Nearest before = nearest_points(kind, at(low)).nearest;
    if (nearest_points(kind, at(high)).nearest == before) continue;
    ++found;
    while (high - low > tiny) {
      const double middle = (low + high) / 2;
      (nearest_points(kind, at(middle)).nearest == before ? low : high) = middle;
    }
    const auto g0 = pair_gradient(frame_of(kind, at(low), threshold));
    const auto g1 = pair_gradient(frame_of(kind, at(high), threshold));
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(g0[i], g1[i], 1e-6) << "at " << low;
    for (const double side : {low - 1e-4, high + 1e-4}) {
      expect_derivatives(kind, at(side), threshold, 1e-7);
    }
  }
  EXPECT_EQ(found, changes);
}

TEST(PairDerivatives, AcrossChangesOfClass) {
  // A vertex passes over a triangle: corner, edge, inside, edge.
  expect_continuous(PairKind::vertex_triangle,
                    {Vector3{-1, -0.8, 0.5}, {0, 0, 0}, {2, 0, 0}, {0.7, 2, 0}}, 0, {3.8, 3.1, 0},
                    never, 3);
  // An edge's end passes over another edge.
  expect_continuous(PairKind::edge_edge,
                    {Vector3{-1, 0, 0}, {1, 0.1, 0}, {-0.2, 0.3, 0.6}, {-0.5, 3, 0.2}}, 2,
                    {0.3, -2, 0}, never, 1);
  // The same for edges that are mollified.
  expect_continuous(PairKind::edge_edge,
                    {Vector3{-1, 0, 0}, {1, 0.1, 0}, {-0.2, 0.3, 0.6}, {-0.5, 3, 0.2}}, 2,
                    {0.3, -2, 0}, 200, 1);
  // A vertex of a plane body passes by an edge: end, inside, end.
  expect_continuous(PairKind::vertex_edge, {Vector3{-1, 0.5, 0}, {0, 0, 0}, {1, 0.2, 0}, {}}, 0,
                    {3, 0, 0}, never, 2);
}

/// Nothing is gained or lost by translations, and the reduced Hessian expands to the whole one.
TEST(PairDerivatives, ReducedHessianIsTheWholeOne) {
  std::mt19937 random(7);
  for (const PairKind kind : all_kinds) {
    for (int trial = 0; trial < 300; ++trial) {
      const PairPoints x = random_points(kind, random);
      const double c = squared_norm(cross(x[1] - x[0], x[3] - x[2]));
      const PairFrame frame = frame_of(kind, x, trial % 2 ? never : 2 * c);
      std::array<double, 144> H, expanded;
      std::array<double, 45> K;
      pair_hessian(frame, H.data());
      pair_reduced_hessian(frame, K.data(), 1);
      expand_reduced(K.data(), 1, expanded.data());
      double largest = 0;
      for (const double h : H) largest = std::max(largest, std::abs(h));
      for (int k = 0; k < 144; ++k) EXPECT_NEAR(H[k], expanded[k], 1e-14 * largest);
    }
  }
}

/// Two negative eigenvalues in every class: the larger share of contact's indefiniteness.
TEST(PairDerivatives, NegativeEigenvalues) {
  std::mt19937 random(8);
  for (const PairKind kind : all_kinds) {
    for (const Nearest nearest : classes_of(kind)) {
      const PairPoints x = random_points_of(kind, nearest, random);
      std::array<double, 144> H, N;
      pair_hessian(frame_of(kind, x, never), H.data());
      int negative = 0;
      ASSERT_EQ(split(12, 1, H.data(), N.data(), &negative).status, SplitStatus::ok);
      EXPECT_EQ(negative, kind == PairKind::vertex_edge ? 1 : 2);
    }
  }
}

/// Turned, mirrored and moved pairs have the same energy, turned gradients and Hessians.
TEST(PairDerivatives, AreObjective) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  for (const PairKind kind : {PairKind::vertex_triangle, PairKind::edge_edge}) {
    for (int trial = 0; trial < 300; ++trial) {
      const PairPoints x = random_points(kind, random);
      Vector3 mirror{normal(random), normal(random), normal(random)};
      mirror = (1 / norm(mirror)) * mirror;
      Vector3 second{normal(random), normal(random), normal(random)};
      second = (1 / norm(second)) * second;
      const auto turned = [&](const Vector3 &v) {
        const Vector3 once = v - (2 * dot(v, mirror)) * mirror;
        return trial % 2 ? once : once - (2 * dot(once, second)) * second;
      };
      PairPoints y;
      for (int a = 0; a < 4; ++a) y[a] = turned(x[a]) + Vector3{3, -2, 1};
      const double c = squared_norm(cross(x[1] - x[0], x[3] - x[2]));
      const PairFrame of_x = frame_of(kind, x, 2 * c), of_y = frame_of(kind, y, 2 * c);
      EXPECT_NEAR(of_x.distance, of_y.distance, 1e-14);
      const auto gx = pair_gradient(of_x), gy = pair_gradient(of_y);
      std::array<double, 144> Hx, Hy;
      pair_hessian(of_x, Hx.data());
      pair_hessian(of_y, Hy.data());
      double largest = 0;
      for (const double h : Hx) largest = std::max(largest, std::abs(h));
      for (int a = 0; a < 4; ++a) {
        const Vector3 g = turned({gx[3 * a], gx[3 * a + 1], gx[3 * a + 2]});
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(g[i], gy[3 * a + i], 1e-12 * largest);
      }
      // Hy (turned e) = turned (Hx e) for one direction of all points.
      Vector3 direction[4], of_Hx[4];
      for (Vector3 &d : direction) d = {normal(random), normal(random), normal(random)};
      for (int row = 0; row < 12; ++row) {
        for (int column = 0; column < 12; ++column) {
          of_Hx[row / 3][row % 3] += Hx[12 * row + column] * direction[column / 3][column % 3];
        }
      }
      for (int row = 0; row < 12; ++row) {
        double sum = 0;
        for (int column = 0; column < 12; ++column) {
          sum += Hy[12 * row + column] * turned(direction[column / 3])[column % 3];
        }
        EXPECT_NEAR(sum, turned(of_Hx[row / 3])[row % 3], 1e-11 * largest);
      }
    }
  }
}

/// Lengths from 1e-6 to 1e6: the same classes, and results that scale as they should.
TEST(PairDerivatives, ScaleWithLength) {
  std::mt19937 random(10);
  for (const PairKind kind : all_kinds) {
    for (int trial = 0; trial < 300; ++trial) {
      const PairPoints x = random_points(kind, random);
      const NearestPoints of_x = nearest_points(kind, x);
      for (const double scale : {1e-6, 1e-3, 1e3, 1e6}) {
        PairPoints y;
        for (int a = 0; a < 4; ++a) y[a] = scale * x[a];
        const NearestPoints of_y = nearest_points(kind, y);
        EXPECT_EQ(of_x.nearest, of_y.nearest);
        EXPECT_NEAR(of_y.distance / scale, of_x.distance, 1e-14);
        // hess of the barrier of d/scale, times scale^2.
        const double d = of_x.distance, wide = 2 * d;
        const Barrier bx = barrier(d, wide), by = barrier(scale * d, scale * wide);
        const double rest = squared_norm(cross(x[1] - x[0], x[3] - x[2]));
        const Mollifier mx = mollifier(x, 2 * rest),
                        my = mollifier(y, 2 * rest * std::pow(scale, 4));
        std::array<double, 144> Hx, Hy;
        pair_hessian(pair_frame(x, 3, of_x, bx, mx), Hx.data());
        pair_hessian(pair_frame(y, 3, of_y, by, my), Hy.data());
        double largest = 0;
        for (const double h : Hx) largest = std::max(largest, std::abs(h));
        for (int k = 0; k < 144; ++k) EXPECT_NEAR(Hy[k] * scale, Hx[k], 1e-10 * largest);
      }
    }
  }
}

TEST(BarrierFunction, DerivativesAndLimits) {
  const double width = 0.3;
  for (const double share : {1e-9, 1e-3, 0.1, 0.5, 0.9, 0.999}) {
    const long double d = share * width, h = 1e-5L * std::min(d, width - d);
    const auto b = [&](long double x) {
      const long double s = x / width;
      return -width * (s - 1) * (s - 1) * std::log(s);
    };
    const Barrier at = barrier(share * width, width);
    EXPECT_DOUBLE_EQ(at.value, barrier_value(share * width, width));
    EXPECT_NEAR(at.value, double(b(d)), 1e-14 * at.value);
    const double first = double((b(d + h) - b(d - h)) / (2 * h));
    const double second = double((b(d + h) - 2 * b(d) + b(d - h)) / (h * h));
    EXPECT_NEAR(at.first, first, 1e-6 * std::abs(first));
    EXPECT_NEAR(at.second, second, 1e-5 * std::abs(second));
    EXPECT_GT(at.second, 0);
  }
  EXPECT_EQ(barrier_value(width, width), 0);
  EXPECT_EQ(barrier(width, width).second, 0);
  EXPECT_EQ(barrier(2 * width, width).first, 0);
  EXPECT_TRUE(std::isinf(barrier_value(0, width)));
  EXPECT_TRUE(std::isinf(barrier_value(-1, width)));
  EXPECT_TRUE(std::isinf(barrier_value(std::nan(""), width)));
}

/// The gap that a pressure leaves, d/dhat at p/kappa = 1e-3 .. 100.
TEST(BarrierFunction, GapUnderPressure) {
  const double gaps[] = {.982, .943, .829, .532, .122, .011};
  for (int k = 0; k < 6; ++k) {
    double low = 1e-9, high = 1;
    for (int step = 0; step < 100; ++step) {
      const double middle = (low + high) / 2;
      (-barrier(middle, 1).first > std::pow(10, k - 3) ? low : high) = middle;
    }
    EXPECT_NEAR(low, gaps[k], 6e-4);
  }
}

}  // namespace
}  // namespace trefoil::contact
