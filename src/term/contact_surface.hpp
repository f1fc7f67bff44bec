#pragma once

#include <petscsys.h>

#include <array>
#include <span>
#include <string>
#include <vector>

#include "contact/surface.hpp"
#include "mesh/mesh.hpp"

namespace trefoil {

/// An obstacle that is a surface: points without unknowns.
struct ObstacleSurface {
  std::string name;
  std::vector<contact::Vector3> points;    ///< where it is before it moves
  std::vector<std::array<int, 3>> facets;  ///< triangles; in the plane edges, with -1 as third
};

/// The surface of all bodies and obstacles, a copy on every rank, and the way from the arrays of
/// local vertices to it and back. Its vertices ascend by the numbers of the mesh file, so that they
/// are the same on any number of ranks; obstacles follow.
class ContactSurface {
 public:
  /// Collective.
  /// @param global_dofs of each local vertex 3, -1 where held
  /// @param stiffness of each local cell, Pa: kappa of the surface in front of it
  PetscErrorCode set_up(const Mesh &mesh, const std::vector<PetscInt> &global_dofs,
                        const std::vector<double> &stiffness,
                        std::span<const ObstacleSurface> obstacles);

  [[nodiscard]] const contact::Surface &surface() const { return surface_; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }
  [[nodiscard]] int rank() const { return rank_; }
  /// Of the bodies' surface, those that this rank owns.
  [[nodiscard]] const std::vector<int> &own_vertices() const { return own_; }
  /// Of the mesh's connected parts and the obstacles, which are bodies after them.
  [[nodiscard]] int first_obstacle() const { return first_obstacle_; }
  [[nodiscard]] const std::string &name_of_obstacle(int body) const {
    return obstacle_names_[static_cast<std::size_t>(body - first_obstacle_)];
  }
  /// Whose file a vertex of this number is in, where bodies come from several; or null.
  [[nodiscard]] const BodyNumbers *file_of(int body, std::int64_t number) const;
  /// The first vertex of each obstacle, and one more.
  [[nodiscard]] const std::vector<int> &obstacle_begin() const { return obstacle_begin_; }

  /// Unknowns of a vertex in the whole system, -1 where there is none.
  [[nodiscard]] const std::array<PetscInt, 3> &dofs(int vertex) const {
    return dofs_[static_cast<std::size_t>(vertex)];
  }
  /// Its number in the distributed mesh, -1 for obstacles.
  [[nodiscard]] PetscInt global_vertex(int vertex) const {
    return global_vertex_[static_cast<std::size_t>(vertex)];
  }

  /// Values of the surface's vertices, 3 each, from those of local vertices; 0 for obstacles.
  /// Collective.
  PetscErrorCode gather(const double *local, std::vector<double> *all) const;
  /// Adds all ranks' values of the surface's vertices at the local vertices of their owners.
  /// Collective.
  PetscErrorCode add_at_owners(const std::vector<double> &all, double *local) const;

  [[nodiscard]] double bytes() const;

 private:
  struct Gathered;
  PetscErrorCode gather_facets(const Mesh &mesh, const std::vector<double> &stiffness,
                               Gathered *gathered) const;
  PetscErrorCode gather_vertices(const Mesh &mesh, const std::vector<PetscInt> &global_dofs,
                                 Gathered *gathered);
  void append_obstacles(std::span<const ObstacleSurface> obstacles,
                        std::vector<contact::SurfaceVertex> *vertices,
                        std::vector<contact::SurfaceFacet> *facets);

  contact::Surface surface_;
  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0, ranks_ = 1;
  int first_obstacle_ = 0;
  std::vector<std::string> obstacle_names_;
  std::vector<BodyNumbers> files_;  ///< of the bodies; see Mesh
  PetscInt file_vertices_ = 0;
  std::vector<int> obstacle_begin_;
  std::vector<std::array<PetscInt, 3>> dofs_;
  std::vector<PetscInt> global_vertex_;
  std::vector<PetscInt> own_local_;    ///< local vertices of own_vertices()
  std::vector<int> own_;               ///< their places in the surface
  std::vector<int> place_;             ///< of all ranks' own vertices, rank by rank
  std::vector<int> counts_, offsets_;  ///< numbers of each rank's, 3 a vertex
};

}  // namespace trefoil
