#include "term/quadratic_changes.hpp"

#include <numeric>

namespace trefoil {

void add_quadratic_changes(
    const std::function<std::vector<double>(const std::vector<double> &)> &product,
    const std::vector<double> &Kw, int directions, const double *const *d, int points,
    const double *coefficients, double *changes) {
  const auto count = static_cast<std::size_t>(directions);
  std::vector<double> slope(count), curvature(count * count);
  for (std::size_t m = 0; m < count; ++m) {
    slope[m] = std::inner_product(Kw.begin(), Kw.end(), d[m], 0.);
    const std::vector<double> Kd = product(std::vector<double>(d[m], d[m] + Kw.size()));
    for (std::size_t n = 0; n < count; ++n) {
      curvature[count * m + n] = std::inner_product(Kd.begin(), Kd.end(), d[n], 0.);
    }
  }
  for (int p = 0; p < points; ++p) {
    const double *c = coefficients + directions * p;
    for (std::size_t m = 0; m < count; ++m) {
      changes[p] += c[m] * slope[m];
      for (std::size_t n = 0; n < count; ++n) {
        changes[p] += 0.5 * c[m] * c[n] * curvature[count * m + n];
      }
    }
  }
}

}  // namespace trefoil
