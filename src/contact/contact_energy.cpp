#include "contact/contact_energy.hpp"

#include <algorithm>

#include "contact/pair_derivatives.hpp"
#include "filter/reduced_filter.hpp"

namespace trefoil::contact {
namespace {

double rest_threshold(const Surface &surface, const std::array<int, 4> &vertices) {
  const auto rest = [&](int a) { return surface.vertices[vertices[a]].rest; };
  return mollifier_threshold(rest(1) - rest(0), rest(3) - rest(2));
}

/// A pair nearer than dhat.
struct ActivePair {
  std::array<int, 4> vertices{};
  double stiffness = 0;
  PairFrame frame;
};

/// @return whether the pair is nearer than dhat
bool activate(const Surface &surface, const ContactLaw &law, const ContactPair &pair,
              std::span<const double> x, ActivePair &active) {
  active.vertices = vertices_of(surface, pair);
  const PairPoints points = points_of(active.vertices, x);
  const NearestPoints nearest = nearest_points(pair.kind, points);
  if (!(nearest.distance < law.distance)) return false;
  Mollifier m;
  if (pair.kind == PairKind::edge_edge) {
    m = mollifier(points, rest_threshold(surface, active.vertices));
  }
  active.stiffness = law.stiffening * pair_stiffness(surface, pair);
  active.frame =
      pair_frame(points, surface.dim, nearest, barrier(nearest.distance, law.distance), m);
  return true;
}

/// The negative part of two points' Hessian: b' / d (c c') (x) P, with the negative slope b'.
bool has_closed_form(const PairFrame &frame) {
  return frame.parameters == 0 && !frame.mollifier.active;
}

void closed_negative_part(const PairFrame &frame, double *N) {
  for (int a = 0; a < 4; ++a) {
    for (int b = 0; b < 4; ++b) {
      const double s = -frame.barrier.first / frame.distance * frame.c[a] * frame.c[b];
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) N[12 * (3 * a + i) + 3 * b + j] = s * frame.P[3 * i + j];
      }
    }
  }
}

/// Pairs up to eight of which go through the filter together.
class HessianBatch {
 public:
  explicit HessianBatch(const std::function<void(const PairHessian &)> &take) : take_(take) {
    pairs_.reserve(most_pairs);
  }

  void add(const ActivePair &active) {
    int lane = no_lane;
    if (!has_closed_form(active.frame)) {
      lane = filtered_++;
      pair_reduced_hessian(active.frame, K_.data() + lane, lanes);
    }
    pairs_.push_back({active, lane});
    if (filtered_ == lanes || pairs_.size() == most_pairs) finish();
  }

  /// Hands over what has been added. Lanes not in use hold matrices of before: nobody looks.
  void finish() {
    if (filtered_ > 0) static_cast<void>(split_reduced(1, K_.data(), N_.data(), negative_.data()));
    for (const Member &member : pairs_) hand_over(member);
    pairs_.clear();
    filtered_ = 0;
  }

  [[nodiscard]] long indefinite() const { return indefinite_; }

 private:
  static constexpr std::size_t most_pairs = 64;
  static constexpr int no_lane = -1;
  struct Member {
    ActivePair active;
    int lane;
  };

  void hand_over(const Member &member) {
    PairHessian result;
    result.vertices = member.active.vertices;
    pair_hessian(member.active.frame, result.H.data());
    if (member.lane == no_lane) {
      closed_negative_part(member.active.frame, result.N.data());
    } else {
      expand_reduced(N_.data() + member.lane, lanes, result.N.data());
    }
    indefinite_ += static_cast<long>(member.lane == no_lane || negative_[member.lane] > 0);
    for (double &h : result.H) h *= member.active.stiffness;
    for (double &n : result.N) n *= member.active.stiffness;
    take_(result);
  }

  const std::function<void(const PairHessian &)> &take_;
  std::vector<Member> pairs_;
  std::array<double, reduced_entries * lanes> K_{}, N_{};
  std::array<int, lanes> negative_{};
  int filtered_ = 0;
  long indefinite_ = 0;
};

}  // namespace

double pair_stiffness(const Surface &surface, const ContactPair &pair) {
  const Primitive &first = first_of(surface, pair), &second = second_of(surface, pair);
  double a = first.area, b = second.area;
  if (first.role == Role::obstacle) a = std::min(a, b);
  if (second.role == Role::obstacle) b = std::min(a, b);
  const double area = pair.kind == PairKind::edge_edge         ? (a + b) / 4
                      : pair.kind == PairKind::vertex_triangle ? a / 4
                                                               : a / 2;
  return std::min(first.stiffness, second.stiffness) * area;
}

double pair_force(const Surface &surface, const ContactLaw &law, const ContactPair &pair,
                  const PairPoints &points, double distance) {
  double m = 1;
  if (pair.kind == PairKind::edge_edge) {
    m = mollifier_value(points, rest_threshold(surface, vertices_of(surface, pair)));
  }
  const double slope = barrier(distance, law.distance).first;
  return -law.stiffening * pair_stiffness(surface, pair) * m * slope;
}

double contact_energy(const Surface &surface, const ContactLaw &law,
                      std::span<const ContactPair> pairs, std::span<const double> x) {
  double energy = 0;
  for (const ContactPair &pair : pairs) {
    const auto vertices = vertices_of(surface, pair);
    const PairPoints points = points_of(vertices, x);
    const double distance = nearest_points(pair.kind, points).distance;
    if (distance >= law.distance) continue;
    if (!(distance > 0)) return std::numeric_limits<double>::infinity();
    double factor = pair_stiffness(surface, pair);
    if (pair.kind == PairKind::edge_edge) {
      factor *= mollifier_value(points, rest_threshold(surface, vertices));
    }
    energy += factor * barrier_value(distance, law.distance);
  }
  return law.stiffening * energy;
}

void add_contact_gradient(const Surface &surface, const ContactLaw &law,
                          std::span<const ContactPair> pairs, std::span<const double> x,
                          std::span<double> gradient) {
  ActivePair active;
  for (const ContactPair &pair : pairs) {
    if (!activate(surface, law, pair, x, active)) continue;
    const auto part = pair_gradient(active.frame);
    for (int a = 0; a < points_of_pair(pair.kind); ++a) {
      for (int i = 0; i < 3; ++i) {
        gradient[3 * static_cast<std::size_t>(active.vertices[a]) + i] +=
            active.stiffness * part[3 * a + i];
      }
    }
  }
}

long contact_hessians(const Surface &surface, const ContactLaw &law,
                      std::span<const ContactPair> pairs, std::span<const double> x,
                      const std::function<void(const PairHessian &)> &take) {
  HessianBatch batch(take);
  ActivePair active;
  for (const ContactPair &pair : pairs) {
    if (activate(surface, law, pair, x, active)) batch.add(active);
  }
  batch.finish();
  return batch.indefinite();
}

LeastGap least_gap(const Surface &surface, std::span<const ContactPair> pairs,
                   std::span<const double> x) {
  LeastGap least;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const PairPoints points = points_of(vertices_of(surface, pairs[k]), x);
    const double gap = nearest_points(pairs[k].kind, points).distance;
    if (gap < least.gap) least = {gap, static_cast<int>(k)};
  }
  return least;
}

std::vector<ContactPair> pairs_within(const Surface &surface, std::span<const ContactPair> pairs,
                                      std::span<const double> x, double distance) {
  std::vector<ContactPair> near;
  for (const ContactPair &pair : pairs) {
    const PairPoints points = points_of(vertices_of(surface, pair), x);
    if (nearest_points(pair.kind, points).distance < distance) near.push_back(pair);
  }
  return near;
}

}  // namespace trefoil::contact
