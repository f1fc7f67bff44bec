#include "contact/additive_ccd.hpp"

#include "contact/separation.hpp"

namespace trefoil::contact {
namespace {

/// A pair at one time of its step, with the plane between its nearest points.
struct Moment {
  double time = 0;
  PairPoints x;
  Vector3 normal;
};

Moment moment_at(PairKind kind, const PairPoints &x, const PairPoints &step, double time) {
  Moment moment{time, moved(x, step, time), {}};
  moment.normal = nearest_points(kind, moment.x).normal;
  return moment;
}

/// How long the plane, held still, keeps corners `least` apart.
double advance_along(PairKind kind, const Moment &now, const PairPoints &step, double least) {
  double advance = std::numeric_limits<double>::infinity();
  for_all_corners(kind, [&](int a, int b) {
    const double speed = -dot(now.normal, step[a] - step[b]);
    if (speed <= 0) return;
    const double room = dot(now.normal, now.x[a] - now.x[b]) - least;
    advance = std::min(advance, room > 0 ? room / speed : 0);
  });
  return advance;
}

/// Whether the plane that turns from one moment's to the other's keeps all corners `least` apart.
bool turning_plane_separates(PairKind kind, const Moment &now, const Moment &then, double least) {
  bool separates = true;
  for_all_corners(kind, [&](int a, int b) {
    const Vector3 r0 = now.x[a] - now.x[b], r1 = then.x[a] - then.x[b];
    separates = separates && dot(now.normal, r0) >= least && dot(then.normal, r1) >= least &&
                dot(now.normal, r1) + dot(then.normal, r0) >= 2 * least;
  });
  return separates;
}

/// eps times the largest coordinates of a pair and its motion.
double rounding_of(PairKind kind, const PairPoints &x, const PairPoints &step) {
  double largest = 0;
  for (int a = 0; a < points_of_pair(kind); ++a) {
    for (int i = 0; i < 3; ++i) {
      largest = std::max(largest, std::abs(x[a][i]) + std::abs(step[a][i]));
    }
  }
  return std::numeric_limits<double>::epsilon() * largest;
}

PairPoints relative_to_first(const PairPoints &points) {
  PairPoints relative;
  for (int a = 1; a < 4; ++a) relative[a] = points[a] - points[0];
  return relative;
}

}  // namespace

double allowed_step(PairKind kind, const PairPoints &points, const PairPoints &motion,
                    const StepLimits &limits, double limit) {
  constexpr int most_advances = 1000;
  constexpr double left_over = 0.01;
  const PairPoints x = relative_to_first(points), step = relative_to_first(motion);
  Moment now = moment_at(kind, x, step, 0);
  const double start = separation(kind, now.normal, x);
  if (!(start > std::max(limits.touching, 100 * rounding_of(kind, x, step)))) return 0;
  const double least = limits.least(start), enough = least + left_over * (start - least);

  double stride = 1;  // of the next trial with a turning plane
  for (int advances = 0; advances < most_advances; ++advances) {
    const double straight = advance_along(kind, now, step, least);
    if (now.time + straight >= limit) return limit;
    stride = std::min(stride, 1 - now.time);
    if (stride > 2 * straight) {
      const Moment then = moment_at(kind, x, step, now.time + stride);
      if (turning_plane_separates(kind, now, then, least)) {
        now = then;
        stride *= 4;
        if (now.time >= limit) return limit;
        continue;
      }
      stride /= 4;
    }
    now = moment_at(kind, x, step, now.time + straight);
    if (separation(kind, now.normal, now.x) <= enough) break;
  }
  return now.time;
}

AllowedStep allowed_step(const Surface &surface, std::span<const ContactPair> pairs,
                         std::span<const double> x, std::span<const double> step,
                         const StepLimits &limits, double limit) {
  AllowedStep allowed{limit};
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto vertices = vertices_of(surface, pairs[k]);
    const double t = allowed_step(pairs[k].kind, points_of(vertices, x), points_of(vertices, step),
                                  limits, allowed.step);
    if (t < allowed.step) allowed = {t, static_cast<int>(k)};
  }
  return allowed;
}

}  // namespace trefoil::contact
