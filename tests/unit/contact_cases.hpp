#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "contact/distances.hpp"

/// Pairs of primitives for the tests of contact, and their distances in quadruple precision by
/// formulas of another kind: orthogonal projection by Gram's matrix, and the least of all parts.
namespace trefoil::contact {

#if defined(__SIZEOF_FLOAT128__)
__extension__ typedef __float128 Wide;
#else
using Wide = long double;
#endif

inline Wide root(Wide x) {
  if (x <= 0) return 0;
  Wide y = std::sqrt(static_cast<long double>(x));
  for (int step = 0; step < 2; ++step) y = (y + x / y) / 2;
  return y;
}

using WideVector = std::array<Wide, 3>;
using WidePoints = std::array<WideVector, 4>;

inline WideVector operator-(const WideVector &a, const WideVector &b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline WideVector operator+(const WideVector &a, const WideVector &b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline WideVector operator*(Wide s, const WideVector &a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline Wide dot(const WideVector &a, const WideVector &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline WideVector cross(const WideVector &a, const WideVector &b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline WidePoints widen(const PairPoints &x) {
  WidePoints wide;
  for (int a = 0; a < 4; ++a) wide[a] = {x[a].x, x[a].y, x[a].z};
  return wide;
}

inline Wide squared_to_edge(const WideVector &p, const WideVector &a, const WideVector &b) {
  const Wide length = dot(b - a, b - a);
  Wide t = length > 0 ? dot(p - a, b - a) / length : Wide(0);
  t = t < 0 ? Wide(0) : t > 1 ? Wide(1) : t;
  const WideVector gap = p - a - t * (b - a);
  return dot(gap, gap);
}

/// The least |r - s e1 - t e2|^2 over (s, t) that `inside` takes; -1 where the minimum is outside.
template <class Inside>
Wide squared_to_plane(const WideVector &r, const WideVector &e1, const WideVector &e2,
                      const Inside &inside) {
  const Wide a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2), determinant = a * c - b * b;
  if (!(determinant > 0)) return -1;
  const Wide s = (c * dot(e1, r) - b * dot(e2, r)) / determinant;
  const Wide t = (a * dot(e2, r) - b * dot(e1, r)) / determinant;
  if (!inside(s, t)) return -1;
  const WideVector gap = r - s * e1 - t * e2;
  return dot(gap, gap);
}

inline Wide reference_distance(PairKind kind, const WidePoints &x) {
  Wide least = squared_to_edge(x[0], x[1], x[2]), face = -1;
  if (kind == PairKind::vertex_triangle) {
    least = std::min({least, squared_to_edge(x[0], x[1], x[3]), squared_to_edge(x[0], x[2], x[3])});
    face = squared_to_plane(x[0] - x[1], x[2] - x[1], x[3] - x[1],
                            [](Wide s, Wide t) { return s >= 0 && t >= 0 && s + t <= 1; });
  } else if (kind == PairKind::edge_edge) {
    least = std::min({squared_to_edge(x[0], x[2], x[3]), squared_to_edge(x[1], x[2], x[3]),
                      squared_to_edge(x[2], x[0], x[1]), squared_to_edge(x[3], x[0], x[1])});
    face = squared_to_plane(x[0] - x[2], x[0] - x[1], x[3] - x[2],
                            [](Wide s, Wide t) { return s >= 0 && s <= 1 && t >= 0 && t <= 1; });
  }
  return root(face >= 0 ? std::min(face, least) : least);
}

inline const std::array<PairKind, 3> all_kinds = {PairKind::vertex_triangle, PairKind::edge_edge,
                                                  PairKind::vertex_edge};

/// Vertices with normally distributed coordinates times `size`, around `centre`; in the plane for a
/// vertex and an edge.
inline PairPoints random_points(PairKind kind, std::mt19937 &random, double size = 1,
                                const Vector3 &centre = {}) {
  std::normal_distribution<double> normal;
  PairPoints x;
  for (int a = 0; a < points_of_pair(kind); ++a) {
    for (int i = 0; i < (kind == PairKind::vertex_edge ? 2 : 3); ++i) {
      x[a][i] = centre[i] + size * normal(random);
    }
  }
  return x;
}

/// The same, of a class.
inline PairPoints random_points_of(PairKind kind, Nearest nearest, std::mt19937 &random,
                                   double size = 1) {
  for (;;) {
    const PairPoints x = random_points(kind, random, size);
    if (nearest_points(kind, x).nearest == nearest) return x;
  }
}

/// The classes of a kind.
inline std::vector<Nearest> classes_of(PairKind kind) {
  std::vector<Nearest> classes = {Nearest::point_point, Nearest::point_edge};
  if (kind == PairKind::vertex_triangle) classes.push_back(Nearest::point_triangle);
  if (kind == PairKind::edge_edge) classes.push_back(Nearest::edge_edge);
  return classes;
}

}  // namespace trefoil::contact
