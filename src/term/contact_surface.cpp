#include "term/contact_surface.hpp"

#include <algorithm>
#include <numeric>

#include "mesh/boundary.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using contact::SurfaceFacet;
using contact::SurfaceVertex;

/// Puts all ranks' lists together, rank by rank. Collective.
template <class Number>
PetscErrorCode gather_lists(MPI_Comm comm, MPI_Datatype type, const std::vector<Number> &mine,
                            std::vector<Number> *all, std::vector<int> *counts) {
  int ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  counts->assign(static_cast<std::size_t>(ranks), 0);
  std::vector<int> offsets(counts->size(), 0);
  const int count = static_cast<int>(mine.size());
  PetscCallMPI(MPI_Allgather(&count, 1, MPI_INT, counts->data(), 1, MPI_INT, comm));
  std::exclusive_scan(counts->begin(), counts->end(), offsets.begin(), 0);
  all->resize(static_cast<std::size_t>(offsets.back() + counts->back()));
  PetscCallMPI(MPI_Allgatherv(mine.data(), count, type, all->data(), counts->data(), offsets.data(),
                              type, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Fields of a vertex as it is sent.
enum Field : std::size_t { number, part, global, first_dof, fields = first_dof + 3 };

}  // namespace

/// What all ranks have of the bodies' surface.
struct ContactSurface::Gathered {
  std::vector<PetscInt> corners;   ///< of facets, 3 each, by numbers of vertices; -1: none
  std::vector<double> stiffness;   ///< of facets
  std::vector<PetscInt> numbers;   ///< of the vertices, ascending
  std::vector<PetscInt> vertices;  ///< Field by Field, rank by rank
  std::vector<double> rest;        ///< their rest positions
  std::vector<int> vertex_counts;  ///< of each rank's numbers in `vertices`
};

PetscErrorCode ContactSurface::gather_facets(const Mesh &mesh, const std::vector<double> &stiffness,
                                             Gathered *gathered) const {
  std::vector<Facet> facets;
  std::vector<PetscInt> mine;
  std::vector<double> of_mine;
  std::vector<int> ignored;
  PetscFunctionBeginUser;
  PetscCall(boundary_facets(
      mesh, [](const Facet &) { return true; }, &facets));
  for (const Facet &facet : facets) {
    const std::size_t begin = mine.size();
    for (int k = 0; k < facet.corners(); ++k) {
      mine.push_back(mesh.vertex_number[static_cast<std::size_t>(facet.begin()[k])]);
    }
    mine.resize(begin + 3, -1);
    of_mine.push_back(stiffness[static_cast<std::size_t>(facet.cell)]);
  }
  PetscCall(gather_lists(comm_, MPIU_INT, mine, &gathered->corners, &ignored));
  PetscCall(gather_lists(comm_, MPI_DOUBLE, of_mine, &gathered->stiffness, &ignored));
  std::vector<PetscInt> &numbers = gathered->numbers;
  std::copy_if(gathered->corners.begin(), gathered->corners.end(), std::back_inserter(numbers),
               [](PetscInt corner) { return corner >= 0; });
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Each rank sends what it owns, whether or not a facet of its own cells has it.
PetscErrorCode ContactSurface::gather_vertices(const Mesh &mesh,
                                               const std::vector<PetscInt> &global_dofs,
                                               Gathered *gathered) {
  std::vector<PetscInt> mine;
  std::vector<double> rest;
  PetscFunctionBeginUser;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    const auto &numbers = gathered->numbers;
    if (!mesh.owned[v] ||
        !std::binary_search(numbers.begin(), numbers.end(), mesh.vertex_number[v])) {
      continue;
    }
    own_local_.push_back(static_cast<PetscInt>(v));
    mine.insert(mine.end(), {mesh.vertex_number[v], mesh.part[v], mesh.global_vertex[v],
                             global_dofs[3 * v], global_dofs[3 * v + 1], global_dofs[3 * v + 2]});
    rest.insert(rest.end(), {mesh.coordinates[3 * v], mesh.coordinates[3 * v + 1],
                             mesh.coordinates[3 * v + 2]});
  }
  PetscCall(gather_lists(comm_, MPIU_INT, mine, &gathered->vertices, &gathered->vertex_counts));
  PetscCall(gather_lists(comm_, MPI_DOUBLE, rest, &gathered->rest, &counts_));
  offsets_.assign(counts_.size(), 0);
  std::exclusive_scan(counts_.begin(), counts_.end(), offsets_.begin(), 0);
  PetscFunctionReturn(PETSC_SUCCESS);
}

void ContactSurface::append_obstacles(std::span<const ObstacleSurface> obstacles,
                                      std::vector<SurfaceVertex> *vertices,
                                      std::vector<SurfaceFacet> *facets) {
  int body = first_obstacle_;
  for (const ObstacleSurface &obstacle : obstacles) {
    const int begin = static_cast<int>(vertices->size());
    obstacle_begin_.push_back(begin);
    obstacle_names_.push_back(obstacle.name);
    for (std::size_t k = 0; k < obstacle.points.size(); ++k) {
      vertices->push_back(
          {obstacle.points[k], static_cast<std::int64_t>(k), body, -1, contact::Role::obstacle});
    }
    for (std::array<int, 3> corners : obstacle.facets) {
      for (int &corner : corners) corner = corner < 0 ? corner : begin + corner;
      facets->push_back({corners, std::numeric_limits<double>::infinity()});
    }
    ++body;
  }
  obstacle_begin_.push_back(static_cast<int>(vertices->size()));
  dofs_.resize(vertices->size(), {-1, -1, -1});
  global_vertex_.resize(vertices->size(), -1);
}

PetscErrorCode ContactSurface::set_up(const Mesh &mesh, const std::vector<PetscInt> &global_dofs,
                                      const std::vector<double> &stiffness,
                                      std::span<const ObstacleSurface> obstacles) {
  Gathered gathered;
  PetscFunctionBeginUser;
  comm_ = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscCallMPI(MPI_Comm_rank(comm_, &rank_));
  PetscCallMPI(MPI_Comm_size(comm_, &ranks_));
  PetscCall(gather_facets(mesh, stiffness, &gathered));
  PetscCall(gather_vertices(mesh, global_dofs, &gathered));
  first_obstacle_ = static_cast<int>(mesh.parts);
  files_ = mesh.bodies;
  file_vertices_ = mesh.file_vertices;

  const std::vector<PetscInt> &numbers = gathered.numbers;
  const auto index_of = [&](PetscInt of) {
    return static_cast<int>(std::lower_bound(numbers.begin(), numbers.end(), of) - numbers.begin());
  };
  std::vector<SurfaceVertex> vertices(numbers.size());
  dofs_.assign(numbers.size(), {-1, -1, -1});
  global_vertex_.assign(numbers.size(), -1);
  std::size_t k = 0;
  for (int owner = 0; owner < ranks_; ++owner) {
    const auto count =
        static_cast<std::size_t>(gathered.vertex_counts[static_cast<std::size_t>(owner)]) /
        Field::fields;
    for (const std::size_t end = k + count; k < end; ++k) {
      const PetscInt *field = &gathered.vertices[Field::fields * k];
      const double *X = &gathered.rest[3 * k];
      const auto at = static_cast<std::size_t>(index_of(field[Field::number]));
      for (std::size_t i = 0; i < 3; ++i) dofs_[at][i] = field[Field::first_dof + i];
      global_vertex_[at] = field[Field::global];
      const bool is_free =
          std::any_of(dofs_[at].begin(), dofs_[at].end(), [](PetscInt dof) { return dof >= 0; });
      vertices[at] = {{X[0], X[1], X[2]},
                      field[Field::number],
                      static_cast<int>(field[Field::part]),
                      owner,
                      is_free ? contact::Role::free : contact::Role::prescribed};
      place_.push_back(static_cast<int>(at));
      if (owner == rank_) own_.push_back(static_cast<int>(at));
    }
  }
  std::vector<SurfaceFacet> facets;
  for (std::size_t f = 0; f < gathered.stiffness.size(); ++f) {
    SurfaceFacet facet{{-1, -1, -1}, gathered.stiffness[f]};
    for (std::size_t c = 0; c < 3; ++c) {
      const PetscInt corner = gathered.corners[3 * f + c];
      if (corner >= 0) facet.vertices[c] = index_of(corner);
    }
    facets.push_back(facet);
  }
  append_obstacles(obstacles, &vertices, &facets);
  surface_ = contact::make_surface(mesh.dimension(), std::move(vertices), std::move(facets));
  PetscFunctionReturn(PETSC_SUCCESS);
}

const BodyNumbers *ContactSurface::file_of(int body, std::int64_t number) const {
  if (body >= first_obstacle_ || files_.empty() || number >= file_vertices_) return nullptr;
  const auto after = std::upper_bound(
      files_.begin(), files_.end(), number,
      [](std::int64_t n, const BodyNumbers &file) { return n < file.first_vertex; });
  return &*std::prev(after);
}

PetscErrorCode ContactSurface::gather(const double *local, std::vector<double> *all) const {
  std::vector<double> mine, gathered(3 * place_.size());
  PetscFunctionBeginUser;
  for (const PetscInt v : own_local_) mine.insert(mine.end(), local + 3 * v, local + 3 * v + 3);
  PetscCallMPI(MPI_Allgatherv(mine.data(), static_cast<int>(mine.size()), MPI_DOUBLE,
                              gathered.data(), counts_.data(), offsets_.data(), MPI_DOUBLE, comm_));
  all->assign(3 * surface_.vertices.size(), 0);
  for (std::size_t k = 0; k < place_.size(); ++k) {
    std::copy_n(gathered.begin() + static_cast<std::ptrdiff_t>(3 * k), 3,
                all->begin() + 3 * static_cast<std::ptrdiff_t>(place_[k]));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ContactSurface::add_at_owners(const std::vector<double> &all, double *local) const {
  std::vector<double> packed(3 * place_.size()), mine(3 * own_.size());
  PetscFunctionBeginUser;
  for (std::size_t k = 0; k < place_.size(); ++k) {
    std::copy_n(all.begin() + 3 * static_cast<std::ptrdiff_t>(place_[k]), 3,
                packed.begin() + static_cast<std::ptrdiff_t>(3 * k));
  }
  PetscCallMPI(
      MPI_Reduce_scatter(packed.data(), mine.data(), counts_.data(), MPI_DOUBLE, MPI_SUM, comm_));
  for (std::size_t k = 0; k < own_local_.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      local[3 * static_cast<std::size_t>(own_local_[k]) + i] += mine[3 * k + i];
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

double ContactSurface::bytes() const {
  return static_cast<double>(surface_.vertices.size() * sizeof(SurfaceVertex) +
                             (surface_.facets.size() + surface_.edges.size()) *
                                 (sizeof(SurfaceFacet) + sizeof(contact::Primitive)));
}

}  // namespace trefoil
