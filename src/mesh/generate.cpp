#include "mesh/generate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "mesh/sweep.hpp"

namespace trefoil {
namespace {

// The vertices of a grid of cells^3 cubes, x running fastest: `place` maps grid positions 0..cells.
template <class Place>
std::vector<double> grid_points(PetscInt cells, const Place &place) {
  std::vector<double> coordinates;
  const auto points = static_cast<std::size_t>(cells + 1);
  coordinates.reserve(3 * points * points * points);
  for (PetscInt k = 0; k <= cells; ++k)
    for (PetscInt j = 0; j <= cells; ++j)
      for (PetscInt i = 0; i <= cells; ++i) {
        const Point point = place(i, j, k);
        coordinates.insert(coordinates.end(), point.begin(), point.end());
      }
  return coordinates;
}

// Cuts a cube of a grid into the six tetrahedra around its diagonal from `start` to the opposite
// corner. Each walks along the axes in one of their six orders. H. Kuhn, "Some combinatorial
// lemmas in topology", IBM J. Res. Dev. 4 (1960).
void append_cube(PetscInt start, const std::array<PetscInt, 3> &steps, bool is_mirrored,
                 std::vector<PetscInt> &cells) {
  constexpr std::size_t orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                        {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (std::size_t order = 0; order < 6; ++order) {
    const PetscInt first = start + steps[orders[order][0]];
    const PetscInt second = first + steps[orders[order][1]];
    const PetscInt last = second + steps[orders[order][2]];
    // The last three orders are odd permutations: left-handed, unless the cube itself is mirrored.
    if ((order >= 3) == is_mirrored)
      cells.insert(cells.end(), {start, first, second, last});
    else
      cells.insert(cells.end(), {start, second, first, last});
  }
}

CellList box(PetscInt cells) {
  CellList mesh;
  mesh.coordinates = grid_points(cells, [&](PetscInt i, PetscInt j, PetscInt k) {
    const double edge = cells;
    return Point{i / edge, j / edge, k / edge};
  });
  const PetscInt points = cells + 1;
  mesh.cells.reserve(24 * static_cast<std::size_t>(cells) * cells * cells);
  for (PetscInt k = 0; k < cells; ++k)
    for (PetscInt j = 0; j < cells; ++j)
      for (PetscInt i = 0; i < cells; ++i)
        append_cube((k * points + j) * points + i, {1, points, points * points}, false, mesh.cells);
  return mesh;
}

// Every other diagonal of a square the other way, so that none of the two is preferred.
CellList square(PetscInt cells) {
  CellList mesh;
  mesh.shape = &shapes::tri3;
  const PetscInt points = cells + 1;
  for (PetscInt j = 0; j <= cells; ++j)
    for (PetscInt i = 0; i <= cells; ++i)
      mesh.coordinates.insert(mesh.coordinates.end(),
                              {i / static_cast<double>(cells), j / static_cast<double>(cells), 0});
  for (PetscInt j = 0; j < cells; ++j)
    for (PetscInt i = 0; i < cells; ++i) {
      const PetscInt a = j * points + i, b = a + 1, c = b + points, d = a + points;
      if ((i + j) % 2 == 0)
        mesh.cells.insert(mesh.cells.end(), {a, b, c, a, c, d});
      else
        mesh.cells.insert(mesh.cells.end(), {a, b, d, b, c, d});
    }
  return mesh;
}

// Maps the cube [-1,1]^3 to the ball of radius 0.5, concentric cubes to concentric spheres. The
// tangent makes cells of about equal angle of cells of equal size.
Point cube_to_ball(const Point &cube) {
  const double size = std::max({std::abs(cube[0]), std::abs(cube[1]), std::abs(cube[2])});
  if (size == 0) return {0, 0, 0};
  Point direction;
  for (std::size_t axis = 0; axis < 3; ++axis)
    direction[axis] = std::tan(std::numbers::pi / 4 * cube[axis] / size);
  const double length = std::hypot(direction[0], direction[1], direction[2]);
  for (double &component : direction) component *= 0.5 * size / length;
  return direction;
}

// The diagonals of the cubes point away from the centre. So every edge of the large cube, which
// becomes flat in the ball, is shared by two tetrahedra that have one face each on the surface;
// one with two faces there would have no volume left.
CellList ball(PetscInt cells_to_surface) {
  const PetscInt half = cells_to_surface, points = 2 * half + 1;
  CellList mesh;
  mesh.coordinates = grid_points(2 * half, [&](PetscInt i, PetscInt j, PetscInt k) {
    const double edge = half;
    return cube_to_ball({(i - half) / edge, (j - half) / edge, (k - half) / edge});
  });
  mesh.cells.reserve(192 * static_cast<std::size_t>(half) * half * half);
  for (PetscInt k = 0; k < 2 * half; ++k)
    for (PetscInt j = 0; j < 2 * half; ++j)
      for (PetscInt i = 0; i < 2 * half; ++i) {
        const bool x_down = i < half, y_down = j < half, z_down = k < half;
        const PetscInt start = ((k + (z_down ? 1 : 0)) * points + j + (y_down ? 1 : 0)) * points +
                               i + (x_down ? 1 : 0);
        append_cube(start,
                    {x_down ? -1 : 1, y_down ? -points : points,
                     z_down ? -points * points : points * points},
                    (x_down != y_down) != z_down, mesh.cells);
      }
  return mesh;
}

constexpr PetscInt cylinder_layers_per_ring = 4;  // length over radius: cells as long as wide

CellList cylinder(PetscInt rings) {
  constexpr double radius = 0.5, length = 2;
  const PetscInt layers = cylinder_layers_per_ring * rings;
  return sweep(Disc(rings), layers, Closure::open, [&](PetscInt layer, double u, double v) {
    return Point{radius * u, radius * v, length * layer / layers};
  });
}

// |c'(t)| of the knot's axis.
double knot_speed(double t) {
  const double torus_radius = 2 + std::cos(3 * t);
  return std::sqrt(9 + 4 * torus_radius * torus_radius);
}

// The parameters of `layers` points at equal arc length on the knot's axis, by inverting a table of
// the arc length.
std::vector<double> knot_parameters(PetscInt layers) {
  const std::size_t samples = 64 * static_cast<std::size_t>(layers);
  const double step = 2 * std::numbers::pi / static_cast<double>(samples);
  std::vector<double> arc_length(samples + 1, 0);
  for (std::size_t sample = 0; sample < samples; ++sample)
    arc_length[sample + 1] =
        arc_length[sample] + step * knot_speed((static_cast<double>(sample) + 0.5) * step);

  std::vector<double> parameters;
  std::size_t sample = 0;
  for (PetscInt layer = 0; layer < layers; ++layer) {
    const double wanted = arc_length.back() * layer / layers;
    while (arc_length[sample + 1] < wanted) ++sample;
    const double share =
        (wanted - arc_length[sample]) / (arc_length[sample + 1] - arc_length[sample]);
    parameters.push_back((static_cast<double>(sample) + share) * step);
  }
  return parameters;
}

// Prisms longer than wide, to stay below 5000 tetrahedra by default; a multiple of 3, so that the
// mesh has the symmetry of the knot.
constexpr PetscInt knot_layers_per_ring = 33;

// The point (u, v) of the unit disc in the plane across the knot's axis at t. Its frame is the
// normal of the torus, which is at right angles to the tangent, and tangent x normal: it closes
// after one turn, which a frame without twist would not.
Point knot_point(double t, double u, double v) {
  constexpr double radius = 0.4;
  const double torus_radius = 2 + std::cos(3 * t), speed = knot_speed(t);
  const Point around_axis{-std::sin(2 * t), std::cos(2 * t), 0};
  const Point normal{std::cos(3 * t) * std::cos(2 * t), std::cos(3 * t) * std::sin(2 * t),
                     std::sin(3 * t)};
  const Point around_tube{-std::sin(3 * t) * std::cos(2 * t), -std::sin(3 * t) * std::sin(2 * t),
                          std::cos(3 * t)};
  const Point axis{torus_radius * std::cos(2 * t), torus_radius * std::sin(2 * t), std::sin(3 * t)};
  // around_axis, around_tube and normal are right-handed, and the tangent is
  // (2 torus_radius around_axis + 3 around_tube) / speed; the binormal is tangent x normal.
  Point point;
  for (std::size_t component = 0; component < 3; ++component) {
    const double binormal =
        (3 * around_axis[component] - 2 * torus_radius * around_tube[component]) / speed;
    point[component] = axis[component] + radius * (u * normal[component] + v * binormal);
  }
  return point;
}

CellList knot(PetscInt rings) {
  const PetscInt layers = knot_layers_per_ring * rings;
  const std::vector<double> parameters = knot_parameters(layers);
  return sweep(Disc(rings), layers, Closure::periodic, [&](PetscInt layer, double u, double v) {
    return knot_point(parameters[static_cast<std::size_t>(layer)], u, v);
  });
}

struct Kind {
  const char *name;
  PetscInt default_resolution;
  PetscInt cells;  // at resolution 1: a multiple of the resolution to the power of the dimension
  int dim;
  CellList (*make)(PetscInt resolution);
};

constexpr Kind kinds[] = {{"box", 8, 6, 3, box},
                          {"cylinder", 4, 18 * cylinder_layers_per_ring, 3, cylinder},
                          {"knot", 2, 18 * knot_layers_per_ring, 3, knot},
                          {"ball", 4, 48, 3, ball},
                          {"square", 40, 2, 2, square}};

const Kind &find_kind(const std::string &name) {
  std::string known;
  for (const Kind &kind : kinds) {
    if (name == kind.name) return kind;
    known += std::string(known.empty() ? "" : ", ") + kind.name;
  }
  throw InputError("no mesh of kind '" + name + "' can be generated; choose one of " + known);
}

// The resolution after `refine` doublings. The array of cells, with 4 entries each, is the longest.
PetscInt refined_resolution(const Kind &kind, PetscInt resolution, PetscInt refine) {
  constexpr double most_entries = std::numeric_limits<std::int32_t>::max();
  const double refined = std::ldexp(resolution == 0 ? kind.default_resolution : resolution,
                                    std::min(refine, PetscInt{64}));
  if (4. * kind.cells * std::pow(refined, kind.dim) > most_entries)
    throw InputError("the generated mesh '" + std::string(kind.name) + "' of resolution " +
                     std::to_string(resolution) + " and refine " + std::to_string(refine) +
                     " would have more than 2^31 entries; lower one of the two");
  return static_cast<PetscInt>(refined);
}

}  // namespace

CellList generate_mesh(const std::string &kind_name, PetscInt resolution, PetscInt refine) {
  const Kind &kind = find_kind(kind_name);
  if (resolution < 0)
    throw InputError("the resolution " + std::to_string(resolution) + " of the generated mesh '" +
                     kind_name + "' is negative; give 0 for the default or more");
  if (refine < 0)
    throw InputError("the number of refinements " + std::to_string(refine) +
                     " of the generated mesh '" + kind_name + "' is negative; give 0 or more");
  return kind.make(refined_resolution(kind, resolution, refine));
}

}  // namespace trefoil
