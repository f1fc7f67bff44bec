#include "scene/loads.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "element/isoparametric_element.hpp"
#include "mesh/boundary.hpp"
#include "scene/expression.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

using Point = std::array<double, 3>;

Point position(const Mesh &mesh, PetscInt vertex) {
  const double *p = &mesh.coordinates[static_cast<std::size_t>(3 * vertex)];
  return {p[0], p[1], p[2]};
}

/// A point of quadrature in a cell or facet at rest.
struct LoadPoint {
  Point position{};
  double weight = 0;  ///< volume or area that it stands for
  double values[ReferenceElement::most_nodes] = {};
};

/// Those of an edge of a plane cell: the middle, or two points for a quadratic one [Gauss].
std::vector<LoadPoint> points_of_edge(const Mesh &mesh, const Facet &edge) {
  std::vector<LoadPoint> points;
  const double offset = edge.count() == 2 ? 0 : std::sqrt(1. / 12);
  for (const double s : edge.count() == 2 ? std::vector<double>{0.5}
                                          : std::vector<double>{0.5 - offset, 0.5 + offset}) {
    const std::array<double, 3> values =
        edge.count() == 2
            ? std::array<double, 3>{1 - s, s, 0}
            : std::array<double, 3>{(1 - s) * (1 - 2 * s), s * (2 * s - 1), 4 * s * (1 - s)};
    const std::array<double, 3> slopes =
        edge.count() == 2 ? std::array<double, 3>{-1, 1, 0}
                          : std::array<double, 3>{4 * s - 3, 4 * s - 1, 4 - 8 * s};
    LoadPoint point;
    Point tangent{};
    for (std::size_t a = 0; a < static_cast<std::size_t>(edge.count()); ++a) {
      const Point p = position(mesh, edge.vertices[a]);
      point.values[a] = values[a];
      for (std::size_t i = 0; i < 3; ++i) {
        point.position[i] += values[a] * p[i];
        tangent[i] += slopes[a] * p[i];
      }
    }
    point.weight = std::hypot(tangent[0], tangent[1]) / (edge.count() == 2 ? 1 : 2);
    points.push_back(point);
  }
  return points;
}

/// Those of a triangle of the surface, straight or bent: the centroid, or three points for a
/// quadratic one.
std::vector<LoadPoint> points_of_triangle(const Mesh &mesh, const Facet &facet) {
  const ReferenceElement &reference = reference_element(2, facet.count());
  std::vector<LoadPoint> points(static_cast<std::size_t>(reference.points));
  for (int q = 0; q < reference.points; ++q) {
    LoadPoint &point = points[static_cast<std::size_t>(q)];
    Point tangents[2] = {};
    for (int a = 0; a < facet.count(); ++a) {
      const Point p = position(mesh, facet.begin()[a]);
      point.values[a] = reference.values[q][a];
      for (std::size_t i = 0; i < 3; ++i) {
        point.position[i] += point.values[a] * p[i];
        for (int k = 0; k < 2; ++k) tangents[k][i] += reference.gradients[q][a][k] * p[i];
      }
    }
    double square = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      const double normal = tangents[0][j] * tangents[1][k] - tangents[0][k] * tangents[1][j];
      square += normal * normal;
    }
    point.weight = std::sqrt(square) * reference.volume / reference.points;
  }
  return points;
}

/// Those of a cell: its element's own.
std::vector<LoadPoint> points_of_cell(const Mesh &mesh, const PetscInt *cell) {
  const ReferenceElement &reference = reference_element(mesh.dimension(), mesh.nodes_per_cell());
  double positions[3 * ReferenceElement::most_nodes];
  for (int a = 0; a < reference.nodes; ++a) {
    const Point p = position(mesh, cell[a]);
    std::copy(p.begin(), p.end(), positions + 3 * a);
  }
  const IsoparametricElement element(reference, positions);
  std::vector<LoadPoint> points(static_cast<std::size_t>(reference.points));
  for (int q = 0; q < reference.points; ++q) {
    LoadPoint &point = points[static_cast<std::size_t>(q)];
    point.weight = element.weight(q);
    for (int a = 0; a < reference.nodes; ++a) {
      point.values[a] = reference.values[q][a];
      for (std::size_t i = 0; i < 3; ++i) {
        point.position[i] += point.values[a] * positions[3 * a + static_cast<int>(i)];
      }
    }
  }
  return points;
}

/// The values of a formula, one for each dimension, none of them `free`. Throws InputError.
Point vector_at(const Mesh &mesh, const Expression &formula, const std::string &option,
                const Point &at, double time) {
  const std::vector<double> values =
      formula.evaluate(at.data(), time, static_cast<std::size_t>(mesh.dimension()));
  if (std::any_of(values.begin(), values.end(), Expression::is_free)) {
    throw InputError(option + ": 'free' is for displacements, not for loads");
  }
  return {values[0], values[1], mesh.dimension() == 3 ? values[2] : 0};
}

/// Adds a force per volume or area at a point, by the shape functions there.
void spread(const Point &force, const LoadPoint &point, const PetscInt *vertices, int count,
            std::vector<double> &forces) {
  for (int a = 0; a < count; ++a) {
    for (std::size_t i = 0; i < 3; ++i) {
      forces[static_cast<std::size_t>(3 * vertices[a]) + i] +=
          force[i] * point.weight * point.values[a];
    }
  }
}

/// rho g, integrated with the shape functions. Throws InputError.
void add_gravity(const Mesh &mesh, const LoadOptions &loads,
                 const std::vector<double> &density_of_cell, double time,
                 std::vector<double> &forces) {
  const std::string option = "-load_gravity";
  const Expression gravity(loads.gravity, option, mesh.box_min, mesh.box_max);
  for (std::size_t c = 0; c < density_of_cell.size(); ++c) {
    const PetscInt *cell = &mesh.cells[static_cast<std::size_t>(mesh.nodes_per_cell()) * c];
    for (const LoadPoint &point : points_of_cell(mesh, cell)) {
      Point force = vector_at(mesh, gravity, option, point.position, time);
      for (double &component : force) component *= density_of_cell[c];
      spread(force, point, cell, mesh.nodes_per_cell(), forces);
    }
  }
}

/// Whether an expression holds at a vertex. Throws InputError.
bool holds(const Mesh &mesh, const Expression &where, const std::string &option, double time,
           PetscInt vertex) {
  const double chosen = where.evaluate(position(mesh, vertex).data(), time, 1)[0];
  if (Expression::is_free(chosen)) {
    throw InputError(option + ": 'free' is for displacements, not for a choice of facets");
  }
  return chosen != 0;
}

/// The facets that a load takes. Collective.
PetscErrorCode facets_of(const Mesh &mesh, const TractionOptions &load, double time,
                         std::vector<Facet> *facets) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  const std::string option = "-load_" + load.name + "_where";
  PetscFunctionBeginUser;
  // Nothing may be thrown while ranks talk to each other, so every vertex is asked before.
  std::vector<char> chosen(mesh.owned.size(), 0);
  const std::string complaint = complaint_of([&] {
    const Expression where(load.where, option, mesh.box_min, mesh.box_max);
    for (PetscInt v = 0; v < mesh.local_vertices(); ++v) {
      chosen[static_cast<std::size_t>(v)] = holds(mesh, where, option, time, v);
    }
  });
  PetscCall(agree_on_complaint(comm, complaint));
  const auto wanted = [&](const Facet &facet) {
    return std::all_of(facet.begin(), facet.begin() + facet.corners(),
                       [&](PetscInt v) { return chosen[static_cast<std::size_t>(v)]; });
  };
  PetscCall(boundary_facets(mesh, wanted, facets));
  auto count = static_cast<PetscInt>(facets->size());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT, MPI_SUM, comm));
  PetscCheck(count > 0, comm, PETSC_ERR_USER_INPUT,
             "load '%s' takes no facet of the surface: %s, which must hold at %s, "
             "is '%s'",
             load.name.c_str(), option.c_str(),
             mesh.dimension() == 3 ? "all three vertices" : "both ends", load.where.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode add_traction(const Mesh &mesh, const TractionOptions &load, double time,
                            std::vector<double> *forces) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  const std::string option = "-load_" + load.name + "_traction";
  std::vector<Facet> facets;
  PetscFunctionBeginUser;
  PetscCall(facets_of(mesh, load, time, &facets));
  const std::string complaint = complaint_of([&] {
    const Expression traction(load.traction, option, mesh.box_min, mesh.box_max);
    for (const Facet &facet : facets) {
      for (const LoadPoint &point :
           mesh.dimension() == 3 ? points_of_triangle(mesh, facet) : points_of_edge(mesh, facet)) {
        spread(vector_at(mesh, traction, option, point.position, time), point, facet.begin(),
               facet.count(), *forces);
      }
    }
  });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode evaluate_loads(const Mesh &mesh, const LoadOptions &loads,
                              const std::vector<double> &density_of_cell, double time,
                              std::vector<double> *forces) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  forces->assign(mesh.coordinates.size(), 0);
  if (!loads.gravity.empty()) {
    double densest = 0;
    for (const double density : density_of_cell) densest = std::max(densest, density);
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &densest, 1, MPI_DOUBLE, MPI_MAX, comm));
    PetscCheck(densest > 0, comm, PETSC_ERR_USER_INPUT,
               "-load_gravity pulls at nothing: give the body a -material_density");
    const std::string complaint =
        complaint_of([&] { add_gravity(mesh, loads, density_of_cell, time, *forces); });
    PetscCall(agree_on_complaint(comm, complaint));
  }
  for (const TractionOptions &load : loads.tractions) {
    PetscCall(add_traction(mesh, load, time, forces));
  }
  PetscCall(sum_at_owners(mesh, forces));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
