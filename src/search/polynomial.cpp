#include "search/polynomial.hpp"

#include <petscsys.h>
// petscblaslapack.h does not stand alone.
#include <petscblaslapack.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trefoil {
namespace {

/// Calls visit(i, j) for the monomials x^i y^j of a polynomial.
template <class Visit>
void for_each_monomial(int variables, int degree, Visit visit) {
  for (int j = 0; j <= (variables > 1 ? degree : 0); ++j) {
    for (int i = 0; i + j <= degree; ++i) visit(i, j);
  }
}

/// Powers of a number, 0 for a negative exponent: derivatives multiply it by zero.
class Powers {
 public:
  explicit Powers(double base) {
    values_[0] = 1;
    for (std::size_t k = 1; k < values_.size(); ++k) values_[k] = base * values_[k - 1];
  }
  double operator[](int exponent) const {
    return exponent < 0 ? 0 : values_[static_cast<std::size_t>(exponent)];
  }

 private:
  std::array<double, 8> values_;  // degrees up to 7
};

/// The Newton step of a quadratic with absolute curvatures: descends whatever the curvatures are.
Polynomial::Point descent_step(int variables, const Polynomial::Point &gradient,
                               const std::array<double, 3> &curvature) {
  const double largest = std::abs(curvature[0]) + std::abs(curvature[1]) + std::abs(curvature[2]);
  const double least = std::max(1e-8 * largest, 1e-300);
  if (variables == 1) return {-gradient[0] / std::max(std::abs(curvature[0]), least), 0};
  // Eigenvectors (cos t, sin t) and (-sin t, cos t).
  const double t = 0.5 * std::atan2(2 * curvature[1], curvature[0] - curvature[2]);
  const double c = std::cos(t), s = std::sin(t);
  const double first = c * c * curvature[0] + 2 * c * s * curvature[1] + s * s * curvature[2];
  const double second = s * s * curvature[0] - 2 * c * s * curvature[1] + c * c * curvature[2];
  const double along = -(c * gradient[0] + s * gradient[1]) / std::max(std::abs(first), least);
  const double across = -(c * gradient[1] - s * gradient[0]) / std::max(std::abs(second), least);
  return {c * along - s * across, s * along + c * across};
}

}  // namespace

std::vector<Polynomial::Point> Polynomial::nodes(int variables, int degree) {
  std::vector<Point> points;
  const auto node = [](int k, int n) { return std::cos(std::numbers::pi * k / n); };
  for (int j = 0; j <= degree; ++j) {
    if (variables == 1) points.push_back({node(j, degree), 0});
    for (int k = j % 2; variables > 1 && k <= degree + 1; k += 2) {
      points.push_back({node(j, degree), node(k, degree + 1)});
    }
  }
  return points;
}

Polynomial::Polynomial(int variables, int degree, const std::vector<double> &values)
    : variables_(variables), degree_(degree), coefficients_(values) {
  const std::vector<Point> points = nodes(variables, degree);
  const auto size = static_cast<PetscBLASInt>(points.size());
  std::vector<double> monomials;  // column by column
  for_each_monomial(variables, degree, [&](int i, int j) {
    for (const Point &p : points) monomials.push_back(Powers(p[0])[i] * Powers(p[1])[j]);
  });
  std::vector<PetscBLASInt> pivots(points.size());
  PetscBLASInt one = 1, info = 0;
  LAPACKgesv_(&size, &one, monomials.data(), &size, pivots.data(), coefficients_.data(), &size,
              &info);  // the nodes are unisolvent: never singular
}

double Polynomial::at(const Point &point, Point *gradient, std::array<double, 3> *curvature) const {
  double value = 0;
  if (gradient) *gradient = {0, 0};
  if (curvature) *curvature = {0, 0, 0};
  const Powers x(point[0]), y(point[1]);
  std::size_t next = 0;
  for_each_monomial(variables_, degree_, [&](int i, int j) {
    const double c = coefficients_[next++];
    const auto term = [&](int less_i, int less_j) { return c * x[i - less_i] * y[j - less_j]; };
    value += term(0, 0);
    if (gradient) {
      (*gradient)[0] += i * term(1, 0);
      (*gradient)[1] += j * term(0, 1);
    }
    if (curvature) {
      (*curvature)[0] += i * (i - 1) * term(2, 0);
      (*curvature)[1] += i * j * term(1, 1);
      (*curvature)[2] += j * (j - 1) * term(0, 2);
    }
  });
  return value;
}

Polynomial::Point Polynomial::minimum_from(const Point &start, double bound) const {
  constexpr int most_iterations = 60, most_halvings = 40;
  Point best = start;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    Point gradient;
    std::array<double, 3> curvature;
    const double value = at(best, &gradient, &curvature);
    const Point step = descent_step(variables_, gradient, curvature);
    Point next = best;
    double scale = 1;
    for (int halving = 0; halving < most_halvings; ++halving, scale *= 0.5) {
      for (std::size_t k = 0; k < 2; ++k) {
        next[k] = std::clamp(best[k] + scale * step[k], -bound, bound);
      }
      if (at(next) < value) break;
    }
    if (!(at(next) < value)) break;
    const double moved = std::hypot(next[0] - best[0], next[1] - best[1]);
    best = next;
    if (moved < 1e-9) break;
  }
  return best;
}

}  // namespace trefoil
