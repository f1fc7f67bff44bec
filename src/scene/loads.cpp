#include "scene/loads.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "element/tet4.hpp"
#include "input_error.hpp"
#include "mesh/boundary.hpp"
#include "petsc_compatibility.hpp"
#include "scene/collective_error.hpp"
#include "scene/expression.hpp"

namespace trefoil {
namespace {

using Point = std::array<double, 3>;

Point position(const Mesh &mesh, PetscInt vertex) {
  const double *p = &mesh.coordinates[static_cast<std::size_t>(3 * vertex)];
  return {p[0], p[1], p[2]};
}

template <class Vertices>
Point centroid(const Mesh &mesh, const Vertices &vertices) {
  Point sum{};
  for (const PetscInt vertex : vertices) {
    for (std::size_t i = 0; i < 3; ++i) {
      sum[i] += position(mesh, vertex)[i] / static_cast<double>(vertices.size());
    }
  }
  return sum;
}

double area(const Mesh &mesh, const Facet &facet) {
  const Point a = position(mesh, facet[0]), b = position(mesh, facet[1]),
              c = position(mesh, facet[2]);
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    const double normal = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
    sum += normal * normal;
  }
  return std::sqrt(sum) / 2;
}

/// Three values of a formula, none of them `free`. Throws InputError.
Point vector_at(const Expression &formula, const std::string &option, const Point &at,
                double time) {
  const std::vector<double> values = formula.evaluate(at.data(), time, 3);
  if (std::any_of(values.begin(), values.end(), Expression::is_free)) {
    throw InputError(option + ": 'free' is for displacements, not for loads");
  }
  return {values[0], values[1], values[2]};
}

template <class Vertices>
void spread(const Point &force, const Vertices &vertices, std::vector<double> &forces) {
  for (const PetscInt vertex : vertices) {
    for (std::size_t i = 0; i < 3; ++i) {
      forces[static_cast<std::size_t>(3 * vertex) + i] +=
          force[i] / static_cast<double>(vertices.size());
    }
  }
}

/// rho g V, a quarter for each corner. Throws InputError.
void add_gravity(const Mesh &mesh, const LoadOptions &loads,
                 const std::vector<double> &density_of_cell, double time,
                 std::vector<double> &forces) {
  const std::string option = "-load_gravity";
  const Expression gravity(loads.gravity, option, mesh.box_min, mesh.box_max);
  for (std::size_t c = 0; c < density_of_cell.size(); ++c) {
    std::array<PetscInt, 4> cell{};
    std::copy_n(mesh.cells.begin() + static_cast<std::ptrdiff_t>(4 * c), 4, cell.begin());
    double corner[4][3];
    for (std::size_t a = 0; a < 4; ++a) {
      const Point p = position(mesh, cell[a]);
      std::copy(p.begin(), p.end(), corner[a]);
    }
    Point force = vector_at(gravity, option, centroid(mesh, cell), time);
    for (double &component : force) {
      component *= density_of_cell[c] * Tet4::at_rest(corner).volume;
    }
    spread(force, cell, forces);
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
    return std::all_of(facet.begin(), facet.end(),
                       [&](PetscInt v) { return chosen[static_cast<std::size_t>(v)]; });
  };
  PetscCall(boundary_facets(mesh, wanted, facets));
  auto count = static_cast<PetscInt>(facets->size());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT, MPI_SUM, comm));
  PetscCheck(count > 0, comm, PETSC_ERR_USER_INPUT,
             "load '%s' takes no facet of the surface: %s, which must hold at all three vertices, "
             "is '%s'",
             load.name.c_str(), option.c_str(), load.where.c_str());
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
      Point force = vector_at(traction, option, centroid(mesh, facet), time);
      for (double &component : force) component *= area(mesh, facet);
      spread(force, facet, *forces);
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
