#include "scene/probes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "element/reference_element.hpp"
#include "input/expression.hpp"
#include "input/selection.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/matrix3.hpp"

namespace trefoil {
namespace {

using Point = std::array<double, 3>;

/// The map of one cell at rest, from reference coordinates to places.
struct CellMap {
  int dimension, nodes;
  double positions[ReferenceElement::most_nodes][3];

  CellMap(const Mesh &mesh, std::size_t cell)
      : dimension(mesh.dimension()), nodes(mesh.nodes_per_cell()) {
    const PetscInt *node = &mesh.cells[static_cast<std::size_t>(nodes) * cell];
    for (int a = 0; a < nodes; ++a) {
      std::copy_n(&mesh.coordinates[static_cast<std::size_t>(3 * node[a])], 3, positions[a]);
    }
  }

  /// One step of Newton's method towards the reference coordinates of a place.
  void approach(const Point &place, Point &reference) const {
    double values[ReferenceElement::most_nodes], gradients[ReferenceElement::most_nodes][3];
    shape_functions(dimension, nodes, reference.data(), values, gradients);
    Matrix3<double> J;
    Point miss = place;
    if (dimension == 2) J(2, 2) = 1;
    for (int a = 0; a < nodes; ++a) {
      for (int i = 0; i < 3; ++i) {
        miss[static_cast<std::size_t>(i)] -= values[a] * positions[a][i];
        for (int j = 0; j < dimension; ++j) J(i, j) += positions[a][i] * gradients[a][j];
      }
    }
    const Matrix3<double> C = cofactor(J);
    const double det = determinant(J);
    for (int j = 0; j < dimension; ++j) {
      for (int i = 0; i < 3; ++i) {
        reference[static_cast<std::size_t>(j)] += C(i, j) * miss[static_cast<std::size_t>(i)] / det;
      }
    }
  }

  /// The least barycentric coordinate: how far inside, in units of the cell.
  [[nodiscard]] double depth(const Point &reference) const {
    double least = 1;
    for (int j = 0; j < dimension; ++j) least -= reference[static_cast<std::size_t>(j)];
    for (int j = 0; j < dimension; ++j)
      least = std::min(least, reference[static_cast<std::size_t>(j)]);
    return least;
  }

  /// Reference coordinates of a place, and how far inside it lies.
  double find(const Point &place, Point &reference) const {
    constexpr int steps = 20;
    constexpr double near = -0.5;  // beyond, a bent cell is not looked at
    reference = {};
    for (int step = 0; step < (nodes > dimension + 1 ? steps : 1); ++step) {
      approach(place, reference);
      if (step == 0 && depth(reference) < near) break;
    }
    return depth(reference);
  }
};

Point place_of(const Mesh &mesh, const ProbeOptions &options) {
  const Expression formula(options.place, "-probe_" + options.name, box_of(mesh));
  const double origin[3] = {};
  std::vector<double> place =
      formula.evaluate(origin, 1, static_cast<std::size_t>(mesh.dimension()));
  place.resize(3, 0);
  return {place[0], place[1], place[2]};
}

/// The vertex of the whole mesh that is nearest to a place. Collective.
PetscErrorCode nearest_vertex(const Mesh &mesh, const Point &place, Point *nearest) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  struct {
    double distance;
    int rank;
  } best{std::numeric_limits<double>::infinity(), 0};
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &best.rank));
  for (std::size_t k = 0; k < mesh.coordinates.size(); k += 3) {
    const double *p = &mesh.coordinates[k];
    const double distance = std::hypot(p[0] - place[0], p[1] - place[1], p[2] - place[2]);
    if (distance >= best.distance) continue;
    best.distance = distance;
    *nearest = {p[0], p[1], p[2]};
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &best, 1, MPI_DOUBLE_INT, MPI_MINLOC, comm));
  PetscCallMPI(MPI_Bcast(nearest->data(), 3, MPI_DOUBLE, best.rank, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode Probes::find_one(const ProbeOptions &options, Probe *probe) const {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm));
  constexpr double rounding = 1e-6;
  struct {
    double depth;
    int rank;
  } best{-std::numeric_limits<double>::infinity(), 0};
  Point place{}, reference{}, nearest{};
  std::size_t cell = 0;
  int rank = 0;
  PetscFunctionBeginUser;
  probe->name = options.name;
  const std::string complaint = complaint_of([&] { place = place_of(*mesh_, options); });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  for (std::size_t c = 0; c < static_cast<std::size_t>(mesh_->local_cells()); ++c) {
    Point inside{};
    const double depth = CellMap(*mesh_, c).find(place, inside);
    if (!(depth > best.depth)) continue;
    best.depth = depth;
    reference = inside;
    cell = c;
  }
  best.rank = rank;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &best, 1, MPI_DOUBLE_INT, MPI_MAXLOC, comm));
  if (best.depth < -rounding) {
    PetscCall(nearest_vertex(*mesh_, place, &nearest));
    SETERRQ(comm, PETSC_ERR_USER_INPUT,
            "probe '%s' at (%g, %g, %g) lies outside of the body at rest; its nearest vertex is at "
            "(%g, %g, %g)",
            options.name.c_str(), place[0], place[1], place[2], nearest[0], nearest[1], nearest[2]);
  }
  if (best.rank == rank) {
    const int nodes = mesh_->nodes_per_cell();
    const auto first = mesh_->cells.begin() + static_cast<std::ptrdiff_t>(cell) * nodes;
    double gradients[ReferenceElement::most_nodes][3];
    probe->vertices.assign(first, first + nodes);
    probe->values.resize(static_cast<std::size_t>(nodes));
    shape_functions(mesh_->dimension(), nodes, reference.data(), probe->values.data(), gradients);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Probes::find(const Mesh &mesh, const std::vector<ProbeOptions> &options) {
  PetscFunctionBeginUser;
  mesh_ = &mesh;
  for (const ProbeOptions &each : options) {
    Probe probe;
    PetscCall(find_one(each, &probe));
    probes_.push_back(std::move(probe));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Probes::report(const double *u, std::vector<ProbeReport> *reports) const {
  PetscFunctionBeginUser;
  reports->clear();
  for (const Probe &probe : probes_) {
    ProbeReport report{probe.name};
    for (std::size_t a = 0; a < probe.vertices.size(); ++a) {
      for (std::size_t i = 0; i < 3; ++i) {
        report.displacement[i] +=
            probe.values[a] * u[3 * probe.vertices[a] + static_cast<PetscInt>(i)];
      }
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, report.displacement.data(), 3, MPI_DOUBLE, MPI_SUM,
                               PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm))));
    reports->push_back(report);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
