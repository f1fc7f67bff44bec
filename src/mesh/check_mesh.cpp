#include "mesh/check_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "mesh/repeated.hpp"

namespace trefoil {
namespace {

using Point = std::array<double, 3>;

enum class RestShape { good, degenerate, negative };

Point minus(const Point &a, const Point &b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

double determinant(const Point &a, const Point &b, const Point &c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

// The power of two that brings the largest of `values` into [1/2, 1): scaling by it rounds nothing.
template <class Values>
int scaling_exponent(const Values &values) {
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  int exponent = 0;
  std::frexp(largest, &exponent);
  return -exponent;
}

// The first node of a cell in the list of cells.
std::size_t first_node(const CellList &mesh, std::size_t cell) {
  return cell * static_cast<std::size_t>(mesh.nodes_per_cell());
}

// The corners of one of a cell's frames, in units in which neither volumes nor edges can over- or
// underflow. Where the plane has no fourth corner the first stands for it.
std::array<Point, 4> scaled_corners(const CellList &mesh, std::size_t cell,
                                    const std::array<int, 4> &frame) {
  std::array<double, 12> entries;
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const auto node = static_cast<std::size_t>(std::max(frame[corner], 0));
    const auto vertex = static_cast<std::size_t>(mesh.cells[first_node(mesh, cell) + node]);
    for (std::size_t component = 0; component < 3; ++component)
      entries[3 * corner + component] = mesh.coordinates[3 * vertex + component];
  }
  const int exponent = scaling_exponent(entries);
  std::array<Point, 4> corners;
  for (std::size_t entry = 0; entry < 12; ++entry)
    corners[entry / 3][entry % 3] = std::ldexp(entries[entry], exponent);
  return corners;
}

double longest_edge(const std::array<Point, 4> &corners) {
  double longest = 0;
  for (std::size_t end = 1; end < 4; ++end)
    for (std::size_t start = 0; start < end; ++start) {
      const Point edge = minus(corners[end], corners[start]);
      longest = std::max(longest, std::hypot(edge[0], edge[1], edge[2]));
    }
  return longest;
}

RestShape shape_of_frame(const std::array<Point, 4> &x, bool is_plane) {
  constexpr double flatness = 1e-14;  // some fifty roundings of the determinant
  const double longest = longest_edge(x);
  // A triangle as the base of a tetrahedron whose fourth corner is as far above it as it is wide.
  const Point up = is_plane ? Point{0, 0, longest} : minus(x[3], x[0]);
  const double six_volumes = determinant(minus(x[1], x[0]), minus(x[2], x[0]), up);
  // Written so that a NaN counts as degenerate.
  if (!(std::abs(six_volumes) > flatness * longest * longest * longest))
    return RestShape::degenerate;
  return six_volumes < 0 ? RestShape::negative : RestShape::good;
}

// The worst of the cell's frames.
RestShape rest_shape(const CellList &mesh, std::size_t cell) {
  RestShape worst = RestShape::good;
  for (const auto &frame : mesh.shape->frames) {
    const RestShape shape =
        shape_of_frame(scaled_corners(mesh, cell, frame), mesh.dimension() == 2);
    if (shape == RestShape::degenerate) return shape;
    if (shape == RestShape::negative) worst = shape;
  }
  return worst;
}

void turn_round(CellList &mesh, std::size_t cell) {
  std::array<PetscInt, CellShape::most_nodes> node;
  const auto begin = mesh.cells.begin() + static_cast<std::ptrdiff_t>(first_node(mesh, cell));
  std::copy_n(begin, mesh.nodes_per_cell(), node.begin());
  std::transform(mesh.shape->mirrored.begin(), mesh.shape->mirrored.end(), begin,
                 [&](int place) { return node[static_cast<std::size_t>(place)]; });
}

// "2 tetrahedra are degenerate", "1 tetrahedron is of negative volume"
std::string counted(PetscInt count, const CellShape &shape, const std::string &property) {
  return counted(count, shape) + (count == 1 ? " is " : " are ") + property;
}

std::string counts_of_bad(const CellList &mesh, const RestCheck &check) {
  const std::string degenerate = counted(check.degenerate, *mesh.shape, "degenerate");
  if (mesh.dimension() == 2) return degenerate;
  return degenerate + " and " + counted(check.negative, *mesh.shape, "of negative volume");
}

// " (tetrahedron 7 is tetrahedron 3 turned round)", or nothing.
std::string text_of_twins(const CellList &mesh) {
  const std::vector<PetscInt> first = first_with_same_corners(mesh);
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    const PetscInt twin = first[static_cast<std::size_t>(cell)];
    if (twin != cell && is_turned_round(mesh, twin) != is_turned_round(mesh, cell))
      return " (" + name_of_cell(mesh, cell) + " is " + name_of_cell(mesh, twin) + " turned round)";
  }
  return "";
}

[[noreturn]] void fail_for_rest_shape(const CellList &mesh, const RestCheck &check,
                                      const std::string &name) {
  throw InputError(name + ": " + counts_of_bad(mesh, check) + ", the first is " +
                   name_of_cell(mesh, check.first - 1) + text_of_twins(mesh) +
                   "; mend the mesh, or leave them out with -mesh_repair drop");
}

// How many facets two kinds of cells have, by the facets' corners.
using FacetCounts = std::map<std::vector<PetscInt>, std::array<int, 2>>;

// Counts the facets of a cell for the kind that it is of: all of them, or those that are there.
void count_facets(const CellList &mesh, std::size_t cell, std::size_t kind, bool adds,
                  FacetCounts &counts) {
  const PetscInt *node = &mesh.cells[first_node(mesh, cell)];
  for (const auto &facet : mesh.shape->facets) {
    std::vector<PetscInt> corners;
    for (std::size_t k = 0; k < static_cast<std::size_t>(mesh.shape->facet->corners); ++k)
      corners.push_back(node[facet[k]]);
    std::sort(corners.begin(), corners.end());
    if (std::adjacent_find(corners.begin(), corners.end()) != corners.end()) continue;
    if (adds)
      ++counts[corners][kind];
    else if (const auto found = counts.find(corners); found != counts.end())
      ++found->second[kind];
  }
}

// Facets that were between a good cell and a bad one. A cell that has collapsed to a facet, which
// it then has twice, leaves its neighbours facing each other.
PetscInt count_open_facets(const CellList &mesh, const std::vector<char> &is_good) {
  constexpr std::size_t good = 0, bad = 1;
  FacetCounts counts;
  for (std::size_t cell = 0; cell < is_good.size(); ++cell)
    if (!is_good[cell]) count_facets(mesh, cell, bad, true, counts);
  for (std::size_t cell = 0; cell < is_good.size(); ++cell)
    if (is_good[cell]) count_facets(mesh, cell, good, false, counts);
  return static_cast<PetscInt>(std::count_if(counts.begin(), counts.end(), [](const auto &facet) {
    return facet.second[good] == 1 && facet.second[bad] == 1;
  }));
}

// Returns how many facets that opens.
PetscInt drop_bad_cells(CellList &mesh) {
  std::vector<PetscInt> good;
  std::vector<char> is_good;
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    is_good.push_back(rest_shape(mesh, static_cast<std::size_t>(cell)) == RestShape::good);
    if (is_good.back()) good.push_back(cell);
  }
  const PetscInt opened = count_open_facets(mesh, is_good);
  keep_cells(mesh, good);
  return opened;
}

// A plane mesh must be plane. Which way round its triangles are written means nothing: they are
// turned anticlockwise.
void lay_flat(CellList &mesh, const std::string &name) {
  double size = 0, height = 0;
  for (std::size_t entry = 0; entry < mesh.coordinates.size(); ++entry)
    (entry % 3 == 2 ? height : size) =
        std::max(entry % 3 == 2 ? height : size, std::abs(mesh.coordinates[entry]));
  if (height > 1e-12 * size)
    throw InputError(name +
                     ": has triangles only and they do not lie in the plane z = 0; give a volume "
                     "mesh, or a plane one");
  for (std::size_t entry = 2; entry < mesh.coordinates.size(); entry += 3)
    mesh.coordinates[entry] = 0;
  for (std::size_t cell = 0; cell < static_cast<std::size_t>(mesh.size()); ++cell) {
    if (rest_shape(mesh, cell) == RestShape::negative) turn_round(mesh, cell);
  }
}

bool all_vertices_coincide(const CellList &mesh) {
  constexpr std::size_t dim = 3;
  for (std::size_t entry = dim; entry < mesh.coordinates.size(); ++entry)
    if (mesh.coordinates[entry] != mesh.coordinates[entry % dim]) return false;
  return true;
}

}  // namespace

PetscInt drop_unused_vertices(CellList &mesh) {
  constexpr PetscInt unused = -1;
  const PetscInt before = mesh.vertices();
  std::vector<PetscInt> new_number(static_cast<std::size_t>(before), unused);
  for (const PetscInt vertex : mesh.cells) new_number[static_cast<std::size_t>(vertex)] = 0;
  PetscInt after = 0;
  for (PetscInt &number : new_number)
    if (number != unused) number = after++;
  if (after < before) renumber_vertices(mesh, new_number, after);
  return before - after;
}

RestCheck check_rest_shape(const CellList &mesh) {
  RestCheck check;
  for (PetscInt cell = 0; cell < mesh.size(); ++cell) {
    const RestShape shape = rest_shape(mesh, static_cast<std::size_t>(cell));
    if (shape == RestShape::good) continue;
    if (check.bad() == 0) check.first = cell + 1;
    ++(shape == RestShape::negative ? check.negative : check.degenerate);
  }
  return check;
}

bool is_turned_round(const CellList &mesh, PetscInt cell) {
  return rest_shape(mesh, static_cast<std::size_t>(cell)) == RestShape::negative;
}

RepairReport repair_rest_shape(CellList &mesh, Repair repair, const std::string &name) {
  RepairReport report;
  if (mesh.size() == 0) throw InputError(name + ": has no tetrahedra; give a volume mesh");
  if (mesh.dimension() == 2) lay_flat(mesh, name);
  RestCheck check = check_rest_shape(mesh);
  if (check.negative > 0 && check.bad() == mesh.size()) {
    for (std::size_t cell = 0; cell < static_cast<std::size_t>(mesh.size()); ++cell)
      turn_round(mesh, cell);
    report.turned = check.negative;
    check = check_rest_shape(mesh);
  }
  if (check.bad() == 0) return report;
  if (repair == Repair::none) fail_for_rest_shape(mesh, check, name);
  if (check.bad() == mesh.size())
    throw InputError(name + ": nothing is left with -mesh_repair drop, because " +
                     counts_of_bad(mesh, check) + "; mend the mesh");
  report.dropped = check.bad();
  report.opened = drop_bad_cells(mesh);
  return report;
}

void normalize(CellList &mesh) {
  if (mesh.vertices() == 0) throw InputError("the mesh to normalize has no vertices; give another");
  if (all_vertices_coincide(mesh))
    throw InputError(
        "all vertices of the mesh to normalize are one point, so it has no size; give another "
        "mesh or leave -mesh_normalize out");

  // First into units in which neither the mean nor the largest distance can overflow.
  const int exponent = scaling_exponent(mesh.coordinates);
  for (double &coordinate : mesh.coordinates) coordinate = std::ldexp(coordinate, exponent);

  constexpr std::size_t dim = 3;
  Point mean{};
  for (std::size_t entry = 0; entry < mesh.coordinates.size(); ++entry)
    mean[entry % dim] += mesh.coordinates[entry];
  for (double &component : mean) component /= mesh.vertices();
  for (std::size_t entry = 0; entry < mesh.coordinates.size(); ++entry)
    mesh.coordinates[entry] -= mean[entry % dim];

  double largest = 0;
  for (std::size_t entry = 0; entry < mesh.coordinates.size(); entry += dim) {
    Point vertex{};
    std::copy_n(mesh.coordinates.begin() + static_cast<std::ptrdiff_t>(entry), dim, vertex.begin());
    largest = std::max(largest, std::hypot(vertex[0], vertex[1], vertex[2]));
  }
  for (double &coordinate : mesh.coordinates) coordinate /= largest;
}

}  // namespace trefoil
