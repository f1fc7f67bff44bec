#include "contact/mollifier.hpp"

namespace trefoil::contact {

double mollifier_threshold(const Vector3 &rest_a, const Vector3 &rest_b) {
  return 1e-3 * squared_norm(rest_a) * squared_norm(rest_b);
}

double mollifier_value(const PairPoints &x, double threshold) {
  const double s = squared_norm(cross(x[1] - x[0], x[3] - x[2])) / threshold;
  return s < 1 ? (2 - s) * s : 1;
}

Mollifier mollifier(const PairPoints &x, double threshold) {
  Mollifier m;
  m.a = x[1] - x[0];
  m.b = x[3] - x[2];
  const Vector3 product = cross(m.a, m.b);
  const double s = squared_norm(product) / threshold;
  if (!(s < 1)) return m;
  m.active = true;
  m.value = (2 - s) * s;
  m.first = 2 * (1 - s) / threshold;
  m.second = -2 / (threshold * threshold);
  m.slope_a = 2 * cross(m.b, product);
  m.slope_b = 2 * cross(product, m.a);
  return m;
}

}  // namespace trefoil::contact
