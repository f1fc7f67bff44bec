// Compiled without contraction of a * b + c, which would break the sums of two_sum().
#include "contact/predicates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace trefoil::contact {
namespace {

/// A sum of doubles without rounding: the terms do not overlap and grow in magnitude, zeros are
/// left out, so that the last one has the sign of all.
template <int capacity>
class ExactSum {
 public:
  void add(double term) {
    double carry = term;
    int kept = 0;
    for (int k = 0; k < size_; ++k) {
      const double sum = carry + terms_[k];
      const double of_term = sum - carry;
      const double error = (carry - (sum - of_term)) + (terms_[k] - of_term);
      if (error != 0) terms_[kept++] = error;
      carry = sum;
    }
    size_ = kept;
    if (carry != 0) terms_[size_++] = carry;
  }

  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }

  void add_product(double a, double b, double c) {
    const double product = a * b, error = std::fma(a, b, -product);
    add_product(error, c);
    add_product(product, c);
  }

  [[nodiscard]] int sign() const { return size_ == 0 ? 0 : terms_[size_ - 1] > 0 ? 1 : -1; }

 private:
  std::array<double, capacity> terms_{};
  int size_ = 0;
};

int sign_of(double x) {
  return (x > 0) - (x < 0);
}

/// sign det[a, b, c], six products of four terms each.
template <int capacity>
void add_determinant(double sign, const Vector3 &a, const Vector3 &b, const Vector3 &c,
                     ExactSum<capacity> &sum) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    sum.add_product(sign * a[i], b[j], c[k]);
    sum.add_product(-sign * a[i], b[k], c[j]);
  }
}

int exact_orientation(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d) {
  ExactSum<4 * 24 + 1> sum;
  add_determinant(1, b, c, d, sum);
  add_determinant(-1, a, c, d, sum);
  add_determinant(1, a, b, d, sum);
  add_determinant(-1, a, b, c, sum);
  return sum.sign();
}

/// In one plane: whether the closed segments a b and c d have a common point, seen along an axis.
bool share_point(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d,
                 int dropped) {
  const int of_a = orientation(c, d, a, dropped), of_b = orientation(c, d, b, dropped);
  const int of_c = orientation(a, b, c, dropped), of_d = orientation(a, b, d, dropped);
  if (of_a * of_b > 0 || of_c * of_d > 0) return false;
  if (of_a != 0 || of_b != 0 || of_c != 0 || of_d != 0) return true;
  for (int i = 0; i < 3; ++i) {  // all on one line
    if (i == dropped) continue;
    if (std::max(a[i], b[i]) < std::min(c[i], d[i])) return false;
    if (std::max(c[i], d[i]) < std::min(a[i], b[i])) return false;
  }
  return true;
}

/// Whether p lies in the closed triangle c d e, seen along an axis; degenerate triangles are left
/// to their edges.
bool is_inside(const Vector3 &p, const Vector3 &c, const Vector3 &d, const Vector3 &e,
               int dropped) {
  const int sides[] = {orientation(c, d, p, dropped), orientation(d, e, p, dropped),
                       orientation(e, c, p, dropped)};
  const auto [least, most] = std::minmax({sides[0], sides[1], sides[2]});
  return orientation(c, d, e, dropped) != 0 && least * most >= 0;
}

/// Segment and triangle in one plane have a common point where they have one in all three
/// projections: what lies in a plane, or on a line, is seen without loss along one axis at least.
bool meet_in_plane(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d,
                   const Vector3 &e) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!share_point(a, b, c, d, axis) && !share_point(a, b, d, e, axis) &&
        !share_point(a, b, e, c, axis) && !is_inside(a, c, d, e, axis)) {
      return false;
    }
  }
  return true;
}

}  // namespace

int orientation(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d) {
  const Vector3 p = b - a, q = c - a, r = d - a;
  const double yz = q.y * r.z, zy = q.z * r.y, zx = q.z * r.x, xz = q.x * r.z, xy = q.x * r.y,
               yx = q.y * r.x;
  const double determinant = p.x * (yz - zy) + p.y * (zx - xz) + p.z * (xy - yx);
  const double size = std::abs(p.x) * (std::abs(yz) + std::abs(zy)) +
                      std::abs(p.y) * (std::abs(zx) + std::abs(xz)) +
                      std::abs(p.z) * (std::abs(xy) + std::abs(yx));
  // Each product carries three differences, two multiplications and three sums: 8 u + O(u^2), with
  // u = 1.1e-16; `size` has rounding errors of its own.
  if (std::abs(determinant) > 1.2e-15 * size) return sign_of(determinant);
  return exact_orientation(a, b, c, d);
}

int orientation(const Vector3 &a, const Vector3 &b, const Vector3 &c, int dropped) {
  const int i = (dropped + 1) % 3, j = (dropped + 2) % 3;
  const double left = (b[i] - a[i]) * (c[j] - a[j]), right = (b[j] - a[j]) * (c[i] - a[i]);
  const double determinant = left - right;
  // Two differences, a product and a sum: 4 u + O(u^2).
  if (std::abs(determinant) > 6e-16 * (std::abs(left) + std::abs(right))) {
    return sign_of(determinant);
  }
  ExactSum<2 * 6 + 1> sum;
  for (const auto &[p, q] : {std::pair(&a, &b), std::pair(&b, &c), std::pair(&c, &a)}) {
    sum.add_product((*p)[i], (*q)[j]);
    sum.add_product(-(*p)[j], (*q)[i]);
  }
  return sum.sign();
}

Meeting segment_meets_triangle(const Vector3 &a, const Vector3 &b, const Vector3 &c,
                               const Vector3 &d, const Vector3 &e) {
  const int of_a = orientation(a, c, d, e), of_b = orientation(b, c, d, e);
  if (of_a * of_b > 0) return Meeting::apart;
  const int sides[] = {orientation(a, b, c, d), orientation(a, b, d, e), orientation(a, b, e, c)};
  const auto [least, most] = std::minmax({sides[0], sides[1], sides[2]});
  if (least * most < 0) return Meeting::apart;
  if (of_a == 0 && of_b == 0) {
    // In one plane, also where c, d, e lie on a line: a skew line would see both signs above.
    return meet_in_plane(a, b, c, d, e) ? Meeting::touching : Meeting::apart;
  }
  const bool proper = of_a * of_b < 0 && sides[0] * sides[1] * sides[2] != 0;
  return proper ? Meeting::crossing : Meeting::touching;
}

Meeting segments_meet(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d) {
  constexpr int z = 2;
  if (!share_point(a, b, c, d, z)) return Meeting::apart;
  const bool proper = orientation(a, b, c, z) * orientation(a, b, d, z) < 0 &&
                      orientation(c, d, a, z) * orientation(c, d, b, z) < 0;
  return proper ? Meeting::crossing : Meeting::touching;
}

}  // namespace trefoil::contact
