#pragma once

#include "contact/vector3.hpp"

namespace trefoil::contact {

/// Exact predicates: signs of determinants of the coordinates as they are stored. A floating-point
/// filter decides nearly all of them; the rest are summed up without rounding [Shewchuk 1997,
/// "Adaptive precision floating-point arithmetic and fast robust geometric predicates"].
/// Coordinates: finite, zero or between 1e-80 and 1e80 in absolute value.

/// The sign of the volume det[b - a, c - a, d - a]: +1 where b, c, d turn counterclockwise seen
/// from a, 0 where the four lie in a plane.
int orientation(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d);

/// The sign of the area of triangle a b c, in the plane without axis `dropped`: +1 counterclockwise
/// in the two others, taken in the cyclic order x y z.
int orientation(const Vector3 &a, const Vector3 &b, const Vector3 &c, int dropped);

/// How two primitives without a common vertex meet.
enum class Meeting {
  apart,     ///< no common point
  touching,  ///< a common point that a small motion could undo: on a border, or in one plane
  crossing   ///< the inside of one passes through the inside of the other
};

/// Segment a b against triangle c d e; degenerate ones included.
Meeting segment_meets_triangle(const Vector3 &a, const Vector3 &b, const Vector3 &c,
                               const Vector3 &d, const Vector3 &e);

/// Segment a b against segment c d in the plane z = 0.
Meeting segments_meet(const Vector3 &a, const Vector3 &b, const Vector3 &c, const Vector3 &d);

}  // namespace trefoil::contact
