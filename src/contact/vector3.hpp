#pragma once

#include <cmath>
#include <span>

namespace trefoil::contact {

/// A point or a direction in space. Points of the plane have z = 0.
struct Vector3 {
  double x = 0, y = 0, z = 0;

  double &operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }

  friend Vector3 operator+(const Vector3 &a, const Vector3 &b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend Vector3 operator-(const Vector3 &a, const Vector3 &b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  friend Vector3 operator*(double s, const Vector3 &a) { return {s * a.x, s * a.y, s * a.z}; }
};

inline double dot(const Vector3 &a, const Vector3 &b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline Vector3 cross(const Vector3 &a, const Vector3 &b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline double squared_norm(const Vector3 &a) {
  return dot(a, a);
}

inline double norm(const Vector3 &a) {
  return std::sqrt(squared_norm(a));
}

/// Point `i` of a list of points, three numbers each.
inline Vector3 point_of(std::span<const double> points, int i) {
  const double *p = points.data() + 3 * static_cast<std::ptrdiff_t>(i);
  return {p[0], p[1], p[2]};
}

}  // namespace trefoil::contact
