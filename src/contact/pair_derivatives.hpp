#pragma once

#include <array>

#include "contact/barrier.hpp"
#include "contact/distances.hpp"
#include "contact/mollifier.hpp"

namespace trefoil::contact {

/// The energy phi(x) = m(x) b(d(x)) of a pair's points, ready for its derivatives.
///
/// The nearest points satisfy r = sum_i c_i x_i = d n and r'q_k = 0, with the weights c and an
/// orthonormal basis q of the edges that they may move along. With w_k, the change of c along q_k,
/// minimising |r|^2 / 2 over the points gives
///     grad d = c (x) n,
///     hess d = (c c') (x) P / d - sum_k [(c (x) q_k)(w_k (x) n)' + (w_k (x) n)(c (x) q_k)']
///              - d sum_k (w_k w_k') (x) (n n'),        P = I - n n' - sum_k q_k q_k'.
/// One formula for all classes: two points have no q, a point and an edge one, a triangle or two
/// edges have two, and then P = 0.
struct PairFrame {
  double distance = 0;
  Vector3 normal;
  std::array<double, 4> c{};
  int parameters = 0;
  std::array<Vector3, 2> q;
  std::array<std::array<double, 4>, 2> w{};
  std::array<double, 9> P{};
  Barrier barrier;
  Mollifier mollifier;  ///< of two edges; else the 1 of a new one
};

/// @param dim      in the plane, P leaves the third direction out
/// @param points   of x, at a distance > 0
/// @param barrier  b, b', b'' at this distance
PairFrame pair_frame(const PairPoints &x, int dim, const NearestPoints &points,
                     const Barrier &barrier, const Mollifier &mollifier);

/// grad phi, 3 a point.
std::array<double, 12> pair_gradient(const PairFrame &frame);

/// hess phi, 12 x 12, row by row; coordinate i of point a is row 3 a + i.
void pair_hessian(const PairFrame &frame, double *H);

/// The same less the translations, which phi does not feel: the lower triangle, packed by rows, of
/// the 9 x 9 matrix in the orthonormal basis h (x) e_i of the Hadamard vectors
/// h = (+ + - -, + - + -, + - - +) / 2; 45 numbers, every `stride`-th of K.
void pair_reduced_hessian(const PairFrame &frame, double *K, int stride);

/// And back: the 12 x 12 matrix of a reduced one.
void expand_reduced(const double *K, int stride, double *H);

}  // namespace trefoil::contact
