#include "contact/pair_derivatives.hpp"

#include <algorithm>

namespace trefoil::contact {
namespace {

using Block = std::array<double, 9>;

void add_outer(double s, const Vector3 &a, const Vector3 &b, Block &to) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) to[3 * i + j] += s * a[i] * b[j];
  }
}

void add_identity(double s, Block &to) {
  for (int i = 0; i < 3; ++i) to[4 * i] += s;
}

/// Vectors of one number a point, or a Hadamard vector: what the formulas are made of.
template <int n>
struct Shapes {
  std::array<double, n> c{}, a{}, b{};  ///< r, and the two edges, are sums of these times points
  std::array<std::array<double, n>, 2> w{};
};

constexpr std::array<double, 4> edge_a = {-1, 1, 0, 0}, edge_b = {0, 0, -1, 1};

Shapes<4> shapes_of_points(const PairFrame &frame) {
  return {frame.c, edge_a, edge_b, frame.w};
}

constexpr double hadamard[3][4] = {{.5, .5, -.5, -.5}, {.5, -.5, .5, -.5}, {.5, -.5, -.5, .5}};

std::array<double, 3> reduced(const std::array<double, 4> &full) {
  std::array<double, 3> result{};
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 4; ++i) result[k] += hadamard[k][i] * full[i];
  }
  return result;
}

Shapes<3> reduced_shapes(const PairFrame &frame) {
  const Shapes<4> full = shapes_of_points(frame);
  return {
      reduced(full.c), reduced(full.a), reduced(full.b), {reduced(full.w[0]), reduced(full.w[1])}};
}

/// m hess b = m (b'' grad d grad d' + b' hess d).
template <int n>
void add_barrier_block(const PairFrame &frame, const Shapes<n> &shapes, int i, int j, Block &to) {
  const double slope = frame.mollifier.value * frame.barrier.first;
  const double curvature = frame.mollifier.value * frame.barrier.second;
  const double ci = shapes.c[i], cj = shapes.c[j];
  double along_normal = curvature * ci * cj;
  Vector3 turn_i, turn_j;
  for (int k = 0; k < frame.parameters; ++k) {
    const double wi = shapes.w[k][i], wj = shapes.w[k][j];
    along_normal -= slope * frame.distance * wi * wj;
    turn_i = turn_i + wi * frame.q[k];
    turn_j = turn_j + wj * frame.q[k];
  }
  add_outer(along_normal, frame.normal, frame.normal, to);
  add_outer(-slope * ci, turn_j, frame.normal, to);
  add_outer(-slope * cj, frame.normal, turn_i, to);
  if (frame.parameters == 2) return;
  for (int e = 0; e < 9; ++e) to[e] += slope / frame.distance * ci * cj * frame.P[e];
}

/// b' (grad m grad d' + grad d grad m') + b hess m, with
///     d2c/da2 = 2 (|b|^2 I - b b'), d2c/db2 = 2 (|a|^2 I - a a'),
///     d2c/dadb = 4 a b' - 2 b a' - 2 (a'b) I
/// for m's argument c = |a|^2 |b|^2 - (a'b)^2.
template <int n>
void add_mollifier_block(const PairFrame &frame, const Shapes<n> &shapes, int i, int j, Block &to) {
  const Mollifier &m = frame.mollifier;
  const double ai = shapes.a[i], aj = shapes.a[j], bi = shapes.b[i], bj = shapes.b[j];
  const Vector3 slope_i = ai * m.slope_a + bi * m.slope_b;
  const Vector3 slope_j = aj * m.slope_a + bj * m.slope_b;
  add_outer(frame.barrier.first * m.first * shapes.c[j], slope_i, frame.normal, to);
  add_outer(frame.barrier.first * m.first * shapes.c[i], frame.normal, slope_j, to);
  add_outer(frame.barrier.value * m.second, slope_i, slope_j, to);

  const double s = frame.barrier.value * m.first;
  add_outer(-2 * s * ai * aj, m.b, m.b, to);
  add_outer(-2 * s * bi * bj, m.a, m.a, to);
  add_outer(s * (4 * ai * bj - 2 * bi * aj), m.a, m.b, to);
  add_outer(s * (4 * bi * aj - 2 * ai * bj), m.b, m.a, to);
  add_identity(2 * s *
                   (ai * aj * squared_norm(m.b) + bi * bj * squared_norm(m.a) -
                    (ai * bj + bi * aj) * dot(m.a, m.b)),
               to);
}

template <int n>
Block hessian_block(const PairFrame &frame, const Shapes<n> &shapes, int i, int j) {
  Block block{};
  add_barrier_block(frame, shapes, i, j, block);
  if (frame.mollifier.active) add_mollifier_block(frame, shapes, i, j, block);
  return block;
}

/// I in the dimensions that there are, less the normal and the edges.
Block remaining_directions(const PairFrame &frame, int dim) {
  Block P{};
  for (int i = 0; i < dim; ++i) P[4 * i] = 1;
  add_outer(-1, frame.normal, frame.normal, P);
  for (int k = 0; k < frame.parameters; ++k) add_outer(-1, frame.q[k], frame.q[k], P);
  return P;
}

/// x = h_0 y_0 + h_1 y_1 + h_2 y_2 for the three coordinates of y, stored at a distance: with
/// s = (y_0 + y_1 + y_2) / 2 the Hadamard vectors give s, y_0 - s, y_1 - s, y_2 - s.
template <int distance>
void expand_vector(const double *y, double *x) {
  for (int i = 0; i < 3; ++i) {
    const double y0 = y[distance * i], y1 = y[distance * (3 + i)], y2 = y[distance * (6 + i)];
    const double s = 0.5 * (y0 + y1 + y2);
    x[distance * i] = s;
    x[distance * (3 + i)] = y0 - s;
    x[distance * (6 + i)] = y1 - s;
    x[distance * (9 + i)] = y2 - s;
  }
}

}  // namespace

/// The edges are columns of J = q R, with R upper triangular; then w = s R^-1 for the numbers s
/// that make J of the points.
PairFrame pair_frame(const PairPoints &x, int dim, const NearestPoints &points,
                     const Barrier &barrier, const Mollifier &mollifier) {
  PairFrame frame;
  frame.distance = points.distance;
  frame.normal = points.normal;
  frame.c = points.weights;
  frame.parameters = points.parameters;
  frame.barrier = barrier;
  frame.mollifier = mollifier;
  if (frame.parameters > 0) {
    const Vector3 edge = x[points.to[0]] - x[points.from[0]];
    const double length = norm(edge);
    frame.q[0] = (1 / length) * edge;
    frame.w[0][points.to[0]] = 1 / length;
    frame.w[0][points.from[0]] = -1 / length;
  }
  if (frame.parameters > 1) {
    const Vector3 edge = x[points.to[1]] - x[points.from[1]];
    frame.q[1] = cross(frame.normal, frame.q[0]);
    const double along = dot(edge, frame.q[0]), across = dot(edge, frame.q[1]);
    frame.w[1][points.to[1]] += 1 / across;
    frame.w[1][points.from[1]] -= 1 / across;
    for (int i = 0; i < 4; ++i) frame.w[1][i] -= along / across * frame.w[0][i];
  }
  if (frame.parameters < 2) frame.P = remaining_directions(frame, dim);
  return frame;
}

std::array<double, 12> pair_gradient(const PairFrame &frame) {
  const Mollifier &m = frame.mollifier;
  std::array<double, 12> gradient{};
  for (int a = 0; a < 4; ++a) {
    Vector3 part = (m.value * frame.barrier.first * frame.c[a]) * frame.normal;
    if (m.active) {
      part =
          part + (frame.barrier.value * m.first) * (edge_a[a] * m.slope_a + edge_b[a] * m.slope_b);
    }
    for (int i = 0; i < 3; ++i) gradient[3 * a + i] = part[i];
  }
  return gradient;
}

void pair_hessian(const PairFrame &frame, double *H) {
  const Shapes<4> shapes = shapes_of_points(frame);
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b <= a; ++b) {
      const Block block = hessian_block(frame, shapes, a, b);
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          H[12 * (3 * a + i) + 3 * b + j] = H[12 * (3 * b + j) + 3 * a + i] = block[3 * i + j];
        }
      }
    }
  }
}

void pair_reduced_hessian(const PairFrame &frame, double *K, int stride) {
  const Shapes<3> shapes = reduced_shapes(frame);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b <= a; ++b) {
      const Block block = hessian_block(frame, shapes, a, b);
      for (int i = 0; i < 3; ++i) {
        const int row = 3 * a + i;
        for (int j = 0; j < 3 && 3 * b + j <= row; ++j) {
          K[stride * (row * (row + 1) / 2 + 3 * b + j)] = block[3 * i + j];
        }
      }
    }
  }
}

void expand_reduced(const double *K, int stride, double *H) {
  double full[9][9], half[9][12];
  for (int row = 0, entry = 0; row < 9; ++row) {
    for (int column = 0; column <= row; ++column, ++entry) {
      full[row][column] = full[column][row] = K[stride * entry];
    }
  }
  for (int row = 0; row < 9; ++row) expand_vector<1>(full[row], half[row]);
  double whole[12][12];
  for (int column = 0; column < 12; ++column)
    expand_vector<12>(&half[0][column], &whole[0][column]);
  // Rounding is not symmetric: one triangle counts.
  for (int row = 0; row < 12; ++row) {
    for (int column = 0; column <= row; ++column) {
      H[12 * row + column] = H[12 * column + row] = whole[row][column];
    }
  }
}

}  // namespace trefoil::contact
