// What contact costs: two nested spheres whose gap is a tenth of an edge, all of it in contact.
// Broad phase in nanoseconds a primitive (vertex, edge or triangle), of boxes alone and with the
// distances that make candidates; distances, energies and CCD in nanoseconds a pair.
//
//   build/tests/benchmarks/contact_benchmark

#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <random>
#include <utility>

#include "contact/contact.hpp"
#include "contact/separation.hpp"
#include "contact/swept_boxes.hpp"

namespace {

using namespace trefoil::contact;

double sink = 0;  // what is computed is used, so that it is computed

/// Nanoseconds of the processor, of the fastest of some calls.
template <class Work>
double nanoseconds(int calls, const Work &work) {
  double least = 1e300;
  for (int call = 0; call < calls; ++call) {
    const std::clock_t begin = std::clock();
    work();
    least = std::min(least, 1e9 / CLOCKS_PER_SEC * static_cast<double>(std::clock() - begin));
  }
  return least;
}

struct Sphere {
  std::vector<Vector3> vertices;
  std::vector<std::array<int, 3>> triangles;
};

/// An icosahedron, every triangle divided in four again and again, on the unit sphere.
Sphere sphere(int divisions) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Sphere s{{{-1, g, 0},
            {1, g, 0},
            {-1, -g, 0},
            {1, -g, 0},
            {0, -1, g},
            {0, 1, g},
            {0, -1, -g},
            {0, 1, -g},
            {g, 0, -1},
            {g, 0, 1},
            {-g, 0, -1},
            {-g, 0, 1}},
           {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
            {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
            {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  for (int division = 0; division < divisions; ++division) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [place, is_new] = middles.try_emplace(std::minmax(a, b), s.vertices.size());
      if (is_new) s.vertices.push_back(0.5 * (s.vertices[a] + s.vertices[b]));
      return place->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto &[a, b, c] : s.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    s.triangles = std::move(finer);
  }
  for (Vector3 &v : s.vertices) v = (1 / norm(v)) * v;
  return s;
}

/// Two of them, the inner one turned a little, so that vertices do not face each other.
Surface nested_spheres(int divisions, double gap) {
  const Sphere s = sphere(divisions);
  const int count = static_cast<int>(s.vertices.size());
  std::vector<SurfaceVertex> vertices;
  std::vector<SurfaceFacet> facets;
  for (int body = 0; body < 2; ++body) {
    const double angle = 0.01 * body, c = std::cos(angle), sine = std::sin(angle);
    for (const Vector3 &v : s.vertices) {
      const Vector3 turned{c * v.x - sine * v.y, sine * v.x + c * v.y, v.z};
      vertices.push_back({(1 - gap * body) * turned, 0, body, 0, Role::free});
    }
    for (const auto &[a, b, d] : s.triangles) {
      facets.push_back({{a + body * count, b + body * count, d + body * count}, 1});
    }
  }
  return make_surface(3, std::move(vertices), std::move(facets));
}

/// The plain additive CCD [Li et al. 2021]: advances by the distance over the largest speeds.
double step_by_norms(const Surface &surface, const ContactPair &pair, const std::vector<double> &x,
                     const std::vector<double> &step) {
  const auto vertices = vertices_of(surface, pair);
  const PairPoints from = points_of(vertices, x);
  PairPoints motion = points_of(vertices, step);
  Vector3 mean;
  for (const Vector3 &v : motion) mean = mean + 0.25 * v;
  double of_first = 0, of_second = 0;
  for (int a = 0; a < 4; ++a) {
    double &largest = a < points_of_first(pair.kind) ? of_first : of_second;
    largest = std::max(largest, norm(motion[a] - mean));
  }
  const double share = StepLimits{}.share, start = nearest_points(pair.kind, from).distance;
  double t = 0, distance = start;
  while (t < 1 && distance > (1 - share) * start * 1.1) {
    t += (distance - (1 - share) * start) / (of_first + of_second);
    distance = nearest_points(pair.kind, moved(from, motion, t)).distance;
  }
  return std::min(t, 1.0);
}

void measure(int divisions) {
  const double edge = 1.1 / (1 << divisions), gap = 0.1 * edge;
  const Surface surface = nested_spheres(divisions, gap);
  const std::vector<double> x = surface.rest_positions();
  const double primitives = surface.vertex_count() + surface.edge_count() + surface.facet_count();
  const int calls = divisions < 6 ? 5 : 3;
  const ContactLaw law{2 * gap};
  const PairSearch search{law.distance};
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-0.2 * edge, 0.2 * edge);
  std::vector<double> step(x.size());
  for (double &s : step) s = noise(random);

  const Sweep sweep(x, {}, 1, law.distance / 2);
  const Box everywhere = region_of_rank(surface, sweep, -1);
  long overlaps = 0;
  const double boxes = nanoseconds(calls, [&] {
    overlaps = 0;
    const auto count = [&](int, int) { ++overlaps; };
    SortedGrid(swept_vertices(surface, sweep, everywhere).boxes,
               swept_facets(surface, sweep, everywhere).boxes)
        .visit_pairs(count);
    SortedGrid(swept_edges(surface, sweep, everywhere).boxes).visit_pairs(count);
  });
  std::vector<ContactPair> pairs, swept;
  const double at_rest = nanoseconds(calls, [&] { pairs = find_candidates(surface, x, search); });
  const double moving =
      nanoseconds(calls, [&] { swept = find_candidates(surface, x, step, search).pairs; });
  const double distances = nanoseconds(calls, [&] { sink += least_gap(surface, swept, x).gap; });
  const double energies =
      nanoseconds(calls, [&] { sink += contact_energy(surface, law, pairs, x); });
  std::vector<double> gradient(x.size());
  const double gradients =
      nanoseconds(calls, [&] { add_contact_gradient(surface, law, pairs, x, gradient); });
  const double hessians = nanoseconds(calls, [&] {
    sink += static_cast<double>(contact_hessians(
        surface, law, pairs, x, [](const PairHessian &hessian) { sink += hessian.N[0]; }));
  });
  AllowedStep allowed;
  const double ccd =
      nanoseconds(calls, [&] { allowed = allowed_step(surface, swept, x, step, StepLimits{}); });
  double each_alone = nanoseconds(1, [&] {
    for (const ContactPair &pair : swept) {
      const auto vertices = vertices_of(surface, pair);
      sink +=
          allowed_step(pair.kind, points_of(vertices, x), points_of(vertices, step), StepLimits{});
    }
  });
  const double checks =
      nanoseconds(1, [&] { sink += find_intersections(surface, x, search).size(); });
  const double by_norms = nanoseconds(1, [&] {
    for (const ContactPair &pair : swept) sink += step_by_norms(surface, pair, x, step);
  });
  const double pair_count = static_cast<double>(pairs.size());
  const double swept_count = static_cast<double>(swept.size());
  std::printf("%d triangles, %.0f primitives, %ld overlapping boxes, %zu pairs, %zu along a step\n",
              surface.facet_count(), primitives, overlaps, pairs.size(), swept.size());
  std::printf(
      "  ns a primitive: boxes %.0f, pairs %.0f, pairs along a step %.0f, exact check %.0f\n",
      boxes / primitives, at_rest / primitives, moving / primitives, checks / primitives);
  std::printf("  ns a pair: distance %.0f, energy %.0f, gradient %.0f, H and N %.0f\n",
              distances / swept_count, energies / pair_count, gradients / pair_count,
              hessians / pair_count);
  std::printf("  ns a pair: allowed step %.0f of all, %.0f of each, %.0f by norms of the motion\n",
              ccd / swept_count, each_alone / swept_count, by_norms / swept_count);
}

}  // namespace

int main() {
  for (int divisions = 5; divisions <= 7; ++divisions) measure(divisions);
  return std::isnan(sink) && sink == 0;
}
