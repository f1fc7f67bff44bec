#include "contact/distances.hpp"

namespace trefoil::contact {
namespace {

/// A point p and the point of an edge from a to b nearest to it, a + t (b - a); gap = p - that.
struct PointEdge {
  double t = 0, squared = 0;
  Vector3 gap;
};

/// Comparisons let an edge without length, whose t is not a number, end at a.
PointEdge nearest_on_edge(const Vector3 &p, const Vector3 &a, const Vector3 &b) {
  const Vector3 edge = b - a, from_a = p - a;
  const double t = dot(from_a, edge) / squared_norm(edge);
  PointEdge result;
  if (!(t > 0)) {
    result.gap = from_a;
  } else if (t >= 1) {
    result.t = 1;
    result.gap = p - b;
  } else {
    result.t = t;
    result.gap = from_a - t * edge;
  }
  result.squared = squared_norm(result.gap);
  return result;
}

/// A vertex p against an edge (a, b), numbers of points of a pair; `sign` -1 where the edge belongs
/// to the first primitive.
struct VertexAgainstEdge {
  int p = 0, a = 0, b = 0;
  double sign = 1;
};

/// The nearest of some vertices against edges.
class BoundarySearch {
 public:
  explicit BoundarySearch(const PairPoints &x) : x_(x) {}

  void look_at(const VertexAgainstEdge &boundary) {
    const PointEdge found = nearest_on_edge(x_[boundary.p], x_[boundary.a], x_[boundary.b]);
    if (any_ && !(found.squared < best_.squared)) return;
    any_ = true;
    best_ = found;
    where_ = boundary;
  }

  [[nodiscard]] bool any() const { return any_; }
  [[nodiscard]] double squared() const { return best_.squared; }

  [[nodiscard]] NearestPoints result() const {
    const auto &[p, a, b, sign] = where_;
    NearestPoints points;
    points.distance = std::sqrt(best_.squared);
    points.weights[p] = sign;
    points.weights[a] = -sign * (1 - best_.t);
    points.weights[b] = -sign * best_.t;
    Vector3 gap = best_.gap;
    if (best_.t > 0 && best_.t < 1) {
      points.nearest = Nearest::point_edge;
      points.parameters = 1;
      points.from[0] = sign > 0 ? b : a;
      points.to[0] = sign > 0 ? a : b;
      // What rounding leaves along the edge would turn the normal of a small gap.
      const Vector3 edge = x_[b] - x_[a];
      gap = gap - (dot(gap, edge) / squared_norm(edge)) * edge;
    }
    const double length = norm(gap);
    if (length > 0) points.normal = (sign / length) * gap;
    return points;
  }

 private:
  const PairPoints &x_;
  bool any_ = false;
  PointEdge best_;
  VertexAgainstEdge where_;
};

/// The minimum of |r - beta1 e1 - beta2 e2| over all numbers beta.
///
/// Products with n = e1 x e2 are wrong by eps |r| / sin of the angle only, where Gram's determinant
/// would square the sine. Near-parallel edges get a step of iterative refinement, from the small
/// gap; they are also not `decided`: whether the betas are inside their bounds may be noise.
struct PlaneMinimum {
  double beta1 = 0, beta2 = 0;
  bool decided = true;
  Vector3 product, gap;

  PlaneMinimum(const Vector3 &r, const Vector3 &e1, const Vector3 &e2) : product(cross(e1, e2)) {
    constexpr double parallel = 1e-4;
    const double squared = squared_norm(product);
    decided = squared > parallel * parallel * squared_norm(e1) * squared_norm(e2);
    gap = r;
    for (int step = 0; step < (decided ? 1 : 2); ++step) {
      const double more1 = dot(cross(gap, e2), product) / squared;
      const double more2 = dot(cross(e1, gap), product) / squared;
      beta1 += more1;
      beta2 += more2;
      gap = gap - more1 * e1 - more2 * e2;
    }
  }

  /// The unit normal on the side of the gap: more accurate than a small gap's own direction.
  [[nodiscard]] Vector3 normal() const {
    const double length = norm(product);
    return (dot(product, gap) < 0 ? -1 / length : 1 / length) * product;
  }
};

/// p = x1 + beta1 (x2 - x1) + beta2 (x3 - x1) + gap; inside where all three barycentric coordinates
/// are positive. Otherwise the nearest point lies on an edge whose coordinate is not: from anywhere
/// else a step towards the foot of the perpendicular leads nearer.
NearestPoints vertex_triangle(const PairPoints &x) {
  const PlaneMinimum foot(x[0] - x[1], x[2] - x[1], x[3] - x[1]);
  const double beta1 = foot.beta1, beta2 = foot.beta2, beta0 = 1 - beta1 - beta2;
  const bool inside = beta0 > 0 && beta1 > 0 && beta2 > 0;
  BoundarySearch search(x);
  if (!inside || !foot.decided) {
    if (!foot.decided || !(beta0 > 0)) search.look_at({0, 2, 3});
    if (!foot.decided || !(beta1 > 0)) search.look_at({0, 1, 3});
    if (!foot.decided || !(beta2 > 0)) search.look_at({0, 1, 2});
    if (!inside || search.squared() <= squared_norm(foot.gap)) return search.result();
  }
  return {Nearest::point_triangle,
          norm(foot.gap),
          foot.normal(),
          {1, -beta0, -beta1, -beta2},
          2,
          {2, 3},
          {1, 1}};
}

/// Edges are nearest where x0 + alpha (x1 - x0) - x2 - beta (x3 - x2) is orthogonal to both, if
/// both numbers are inside (0, 1). Otherwise the minimum of the convex function lies where one of
/// them is at the bound that it exceeds: from anywhere else a step towards the free minimum leads
/// down.
NearestPoints edge_edge(const PairPoints &x) {
  const PlaneMinimum foot(x[0] - x[2], x[0] - x[1], x[3] - x[2]);
  const double alpha = foot.beta1, beta = foot.beta2;
  const bool inside = alpha > 0 && alpha < 1 && beta > 0 && beta < 1;
  BoundarySearch search(x);
  if (!inside || !foot.decided) {
    if (!foot.decided || !(alpha > 0)) search.look_at({0, 2, 3, 1});
    if (!foot.decided || !(alpha < 1)) search.look_at({1, 2, 3, 1});
    if (!foot.decided || !(beta > 0)) search.look_at({2, 0, 1, -1});
    if (!foot.decided || !(beta < 1)) search.look_at({3, 0, 1, -1});
    if (!inside || search.squared() <= squared_norm(foot.gap)) return search.result();
  }
  return {Nearest::edge_edge,
          norm(foot.gap),
          foot.normal(),
          {1 - alpha, alpha, beta - 1, -beta},
          2,
          {0, 3},
          {1, 2}};
}

}  // namespace

NearestPoints nearest_points(PairKind kind, const PairPoints &x) {
  if (kind == PairKind::vertex_triangle) return vertex_triangle(x);
  if (kind == PairKind::edge_edge) return edge_edge(x);
  BoundarySearch search(x);
  search.look_at({0, 1, 2});
  return search.result();
}

}  // namespace trefoil::contact
