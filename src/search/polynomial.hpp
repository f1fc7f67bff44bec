#pragma once

#include <array>
#include <vector>

namespace trefoil {

/// A polynomial in one or two variables of given total degree, that goes through given values at
/// nodes spread over [-1, 1] or the square: what is known of the energy on a line or plane.
class Polynomial {
 public:
  using Point = std::array<double, 2>;

  /// Where values are wanted: Chebyshev-Lobatto nodes on the interval; on the square the Padua
  /// points (Caliari, De Marchi, Vianello 2005), the nodes of that number between which a
  /// polynomial swings least.
  static std::vector<Point> nodes(int variables, int degree);

  /// Through `values` at the nodes, in their order.
  Polynomial(int variables, int degree, const std::vector<double> &values);

  /// The value at a point, and where not null the gradient and the second derivatives xx, xy, yy.
  [[nodiscard]] double at(const Point &point, Point *gradient = nullptr,
                          std::array<double, 3> *curvature = nullptr) const;

  /// A minimum that descent by Newton's method reaches from `start`, inside |x|, |y| <= bound.
  [[nodiscard]] Point minimum_from(const Point &start, double bound) const;

 private:
  int variables_, degree_;
  std::vector<double> coefficients_;  ///< of x^i y^j, i + j <= degree: j = 0 first
};

}  // namespace trefoil
