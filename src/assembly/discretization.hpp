#pragma once

#include <petscmat.h>

#include <array>
#include <vector>

#include "assembly/turned_vertex.hpp"
#include "mesh/mesh.hpp"
#include "term/vertex_pairs.hpp"

namespace trefoil {

/// What a scene holds of each local vertex: 3 entries a vertex.
struct HeldDofs {
  std::vector<char> held;     ///< this component is prescribed
  std::vector<double> value;  ///< its displacement; 0 where free
  /// Vertices that are held along other axes than those of space, none of whose components are held
  /// above; in the plane the last axis leads out of it.
  std::vector<TurnedVertex> turned = {};
};

/// Nothing held but, in a plane mesh, the third components: plane strain.
HeldDofs nothing_held(const Mesh &mesh);

/// The unknowns of a mesh: displacements of the vertices, 3 a vertex, less those that are held.
/// Vectors of unknowns are PETSc's global vectors of mesh.dm; local arrays hold 3 numbers for each
/// local vertex, held ones and ghosts included.
class Discretization {
 public:
  Discretization() = default;
  Discretization(const Discretization &) = delete;
  Discretization &operator=(const Discretization &) = delete;
  ~Discretization();

  /// Collective; once. Keeps a reference to `mesh`, which must outlive it. In a plane mesh `held`
  /// holds all third components, see nothing_held().
  PetscErrorCode set_up(Mesh &mesh, const HeldDofs &held);

  /// Moves what is held to other displacements; the same dofs must be held. Collective.
  PetscErrorCode set_prescribed(const HeldDofs &held);

  /// A vector of unknowns, zero.
  PetscErrorCode create_vector(Vec *x) const;

  /// The matrix of the Hessian, zero: AIJ with the pattern of the cells, block size 3 (in the plane
  /// 2) where every vertex is wholly free or wholly held, rigid-body modes attached. Collective.
  PetscErrorCode create_matrix(Mat *matrix) const;
  /// Gives such a matrix another pattern: that of the cells and of further pairs of vertices, each
  /// in both orders, of any ranks. Its values are zero then. Collective.
  PetscErrorCode set_pattern(const VertexPairs &pairs, Mat matrix) const;

  /// Displacements of all local vertices: the unknowns of x, prescribed values where held.
  /// Collective. Give the array back with restore_local().
  PetscErrorCode get_local(Vec x, Vec *local, const PetscScalar **u) const;
  /// The same in an array of one's own. Collective.
  PetscErrorCode copy_local(Vec x, std::vector<double> *u) const;
  /// The same for a direction, a change of the unknowns: 0 where held.
  PetscErrorCode get_local_direction(Vec d, Vec *local, const PetscScalar **values) const;
  PetscErrorCode restore_local(Vec *local, const PetscScalar **u) const;

  /// Adds up local contributions, 3 a local vertex, into a vector of unknowns; turns them along the
  /// axes of turned vertices. Collective.
  PetscErrorCode add_to_global(Vec local, Vec global) const;

  /// Of a Hessian that was put together as if turned vertices were free: for their unknowns, with
  /// the rows and columns of the held ones zero but, with `has_diagonal`, on the diagonal. Nothing
  /// where no vertex is turned. Collective.
  PetscErrorCode turn_matrix(Mat matrix, bool has_diagonal) const;
  /// Displacements of local vertices, 3 each, as unknowns: for turned ones along their axes.
  void turn_to_axes(double *values) const;
  /// Whether any vertex of any rank is turned.
  [[nodiscard]] bool any_turned() const { return any_turned_; }
  [[nodiscard]] const std::vector<TurnedVertex> &turned() const { return turned_; }

  /// Global number of each local dof, -1 where held.
  [[nodiscard]] const std::vector<PetscInt> &global_dofs() const { return global_dofs_; }
  [[nodiscard]] std::array<PetscInt, 3> dofs_of_vertex(PetscInt local_vertex) const {
    const PetscInt *first = &global_dofs_[static_cast<std::size_t>(3 * local_vertex)];
    return {first[0], first[1], first[2]};
  }
  [[nodiscard]] PetscInt total_dofs() const { return total_; }
  [[nodiscard]] PetscInt block_size() const { return block_size_; }
  /// Whether every vertex is wholly free or wholly held.
  [[nodiscard]] bool has_whole_blocks() const { return block_size_ == mesh_->dimension(); }
  [[nodiscard]] const Mesh &mesh() const { return *mesh_; }
  [[nodiscard]] double bytes() const;

 private:
  PetscErrorCode turn_to_space(Vec local, bool prescribes) const;
  PetscErrorCode make_rotation(Mat like) const;
  PetscErrorCode number_dofs(const HeldDofs &held);
  PetscErrorCode attach_rigid_body_modes(Mat matrix) const;
  PetscErrorCode create_vertex_graph(const VertexPairs &pairs, Mat *graph) const;
  PetscErrorCode dofs_of_ghost_columns(Mat graph, std::vector<PetscInt> *dofs) const;
  PetscErrorCode row_pattern(const VertexPairs &pairs, std::vector<PetscInt> *start,
                             std::vector<PetscInt> *column) const;

  Mesh *mesh_ = nullptr;
  Vec prescribed_ = nullptr;  ///< local: values where held, 0 elsewhere
  std::vector<PetscInt> global_dofs_;
  PetscInt total_ = 0, block_size_ = 3;
  std::vector<TurnedVertex> turned_;
  bool any_turned_ = false;  ///< on any rank
  mutable Mat rotation_ = nullptr;
  mutable std::vector<PetscInt> held_rows_;
};

/// Refuses a matrix of whose rows a rank holds more entries than a PetscInt can count. Collective.
/// @param entries of this rank's rows
PetscErrorCode check_matrix_size(MPI_Comm comm, PetscInt64 entries);

/// Rigid-body modes at rest positions: translations 0..2 and rotations 3..5 about `centre`.
/// @return component i of mode m at position p
double rigid_body_mode(int m, int i, const double *p, const std::array<double, 3> &centre);

}  // namespace trefoil
