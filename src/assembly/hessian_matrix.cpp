#include <petscsf.h>

#include <algorithm>
#include <array>

#include "assembly/discretization.hpp"
#include "assembly/near_null_space.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// Copies the structure of a sequential AIJ matrix.
PetscErrorCode copy_rows(Mat matrix, std::vector<PetscInt> *start, std::vector<PetscInt> *column) {
  PetscInt rows = 0;
  const PetscInt *i = nullptr, *j = nullptr;
  PetscBool done = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(MatGetRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &rows, &i, &j, &done));
  start->assign(i, i + rows + 1);
  column->assign(j, j + i[rows]);
  PetscCall(MatRestoreRowIJ(matrix, 0, PETSC_FALSE, PETSC_FALSE, &rows, &i, &j, &done));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

/// The graph of the owned vertices and their neighbours, themselves included, as an AIJ matrix with
/// a row a vertex. PETSc's coordinate format makes it from the cells' pairs of vertices, those of
/// other ranks' cells included, and from the further ones.
PetscErrorCode Discretization::create_vertex_graph(const VertexPairs &pairs, Mat *graph) const {
  const Mesh &mesh = *mesh_;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm));
  PetscFunctionBeginUser;
  std::vector<PetscInt> row, column;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  row.reserve(width * mesh.cells.size());
  column.reserve(width * mesh.cells.size());
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    for (std::size_t a = 0; a < width; ++a) {
      for (std::size_t b = 0; b < width; ++b) {
        row.push_back(mesh.global_vertex[static_cast<std::size_t>(mesh.cells[c + a])]);
        column.push_back(mesh.global_vertex[static_cast<std::size_t>(mesh.cells[c + b])]);
      }
    }
  }
  row.insert(row.end(), pairs.first.begin(), pairs.first.end());
  row.insert(row.end(), pairs.second.begin(), pairs.second.end());
  column.insert(column.end(), pairs.second.begin(), pairs.second.end());
  column.insert(column.end(), pairs.first.begin(), pairs.first.end());
  const auto owned = static_cast<PetscInt>(std::count(mesh.owned.begin(), mesh.owned.end(), 1));
  PetscCall(MatCreate(comm, graph));
  PetscCall(MatSetSizes(*graph, owned, owned, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetType(*graph, MATAIJ));
  PetscCall(MatSetPreallocationCOO(*graph, static_cast<PetscCount>(row.size()), row.data(),
                                   column.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Global dofs of the columns of the graph's rows that are not this rank's vertices: 3 a column, -1
/// where held.
PetscErrorCode Discretization::dofs_of_ghost_columns(Mat graph, std::vector<PetscInt> *dofs) const {
  const Mesh &mesh = *mesh_;
  Mat here = nullptr, elsewhere = nullptr;
  const PetscInt *ghosts = nullptr, *ranges = nullptr;
  PetscInt count = 0, begin = 0, end = 0;
  PetscSF owners = nullptr;
  PetscLayout layout = nullptr;
  MPI_Datatype triple = MPI_DATATYPE_NULL;
  PetscFunctionBeginUser;
  PetscCall(MatMPIAIJGetSeqAIJ(graph, &here, &elsewhere, &ghosts));
  PetscCall(MatGetSize(elsewhere, nullptr, &count));
  PetscCall(MatGetLayouts(graph, &layout, nullptr));
  PetscCall(PetscLayoutGetRanges(layout, &ranges));
  PetscCall(PetscLayoutGetRange(layout, &begin, &end));
  std::vector<PetscInt> mine(static_cast<std::size_t>(3 * (end - begin)), -1);
  std::size_t vertex = 0;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    std::copy_n(global_dofs_.begin() + static_cast<std::ptrdiff_t>(3 * v), 3,
                mine.begin() + static_cast<std::ptrdiff_t>(3 * vertex++));
  }
  dofs->assign(static_cast<std::size_t>(3 * count), -1);
  PetscCall(PetscSFCreate(PetscObjectComm(reinterpret_cast<PetscObject>(graph)), &owners));
  PetscCall(PetscSFSetGraphLayout(owners, layout, count, nullptr, PETSC_OWN_POINTER, ghosts));
  PetscCallMPI(MPI_Type_contiguous(3, MPIU_INT, &triple));
  PetscCallMPI(MPI_Type_commit(&triple));
  PetscCall(PetscSFBcastBegin(owners, triple, mine.data(), dofs->data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(owners, triple, mine.data(), dofs->data(), MPI_REPLACE));
  PetscCallMPI(MPI_Type_free(&triple));
  PetscCall(PetscSFDestroy(&owners));
  PetscFunctionReturn(PETSC_SUCCESS);
}

namespace {

/// Vertices of this rank, the neighbours of each, and the dofs of both: 3 a vertex, -1 where held.
struct Neighbourhoods {
  std::vector<PetscInt> own_dofs, ghost_dofs;
  std::array<std::vector<PetscInt>, 2> first, neighbours;  ///< of this rank's, of others' vertices

  [[nodiscard]] std::size_t size() const { return own_dofs.size() / 3; }
  [[nodiscard]] PetscInt rows(std::size_t vertex) const {
    const auto dof = own_dofs.begin() + static_cast<std::ptrdiff_t>(3 * vertex);
    return static_cast<PetscInt>(std::count_if(dof, dof + 3, [](PetscInt d) { return d >= 0; }));
  }
  /// The free dofs of a vertex's neighbours, itself included, in no order.
  void columns(std::size_t vertex, std::vector<PetscInt> *row) const {
    row->clear();
    for (std::size_t p = 0; p < 2; ++p) {
      const auto &dofs = p == 0 ? own_dofs : ghost_dofs;
      if (first[p].empty()) continue;
      for (PetscInt e = first[p][vertex]; e < first[p][vertex + 1]; ++e) {
        const auto neighbour = static_cast<std::size_t>(neighbours[p][static_cast<std::size_t>(e)]);
        for (std::size_t i = 0; i < 3; ++i) {
          if (dofs[3 * neighbour + i] >= 0) row->push_back(dofs[3 * neighbour + i]);
        }
      }
    }
  }
};

}  // namespace

/// The exact pattern: each free dof's row has the free dofs of its vertex's neighbours.
PetscErrorCode Discretization::row_pattern(const VertexPairs &pairs, std::vector<PetscInt> *start,
                                           std::vector<PetscInt> *column) const {
  const Mesh &mesh = *mesh_;
  Mat graph = nullptr, parts[2] = {nullptr, nullptr};
  PetscBool sequential = PETSC_FALSE;
  Neighbourhoods known;
  std::vector<PetscInt> row;
  PetscInt64 entries = 0;
  PetscFunctionBeginUser;
  PetscCall(create_vertex_graph(pairs, &graph));
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(graph), MATSEQAIJ, &sequential));
  parts[0] = graph;
  if (!sequential) {
    PetscCall(MatMPIAIJGetSeqAIJ(graph, &parts[0], &parts[1], nullptr));
    PetscCall(dofs_of_ghost_columns(graph, &known.ghost_dofs));
  }
  for (std::size_t p = 0; p < 2; ++p) {
    if (parts[p]) PetscCall(copy_rows(parts[p], &known.first[p], &known.neighbours[p]));
  }
  PetscCall(MatDestroy(&graph));
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    if (!mesh.owned[v]) continue;
    const auto dofs = global_dofs_.begin() + static_cast<std::ptrdiff_t>(3 * v);
    known.own_dofs.insert(known.own_dofs.end(), dofs, dofs + 3);
  }
  for (std::size_t vertex = 0; vertex < known.size(); ++vertex) {
    known.columns(vertex, &row);
    entries += known.rows(vertex) * static_cast<PetscInt64>(row.size());
  }
  PetscCall(check_matrix_size(PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm)), entries));
  column->reserve(static_cast<std::size_t>(entries));
  start->assign(1, 0);
  for (std::size_t vertex = 0; vertex < known.size(); ++vertex) {
    known.columns(vertex, &row);
    std::sort(row.begin(), row.end());
    for (PetscInt i = known.rows(vertex); i > 0; --i) {
      column->insert(column->end(), row.begin(), row.end());
      start->push_back(static_cast<PetscInt>(column->size()));
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_matrix_size(MPI_Comm comm, PetscInt64 entries) {
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &entries, 1, MPIU_INT64, MPI_MAX, comm));
  PetscCheck(entries <= PETSC_MAX_INT, comm, PETSC_ERR_USER_INPUT,
             "a rank's rows of the Hessian would have %" PetscInt64_FMT
             " entries, and this PETSc counts to %" PetscInt_FMT
             "; use more ranks, or a PETSc with 64-bit indices",
             entries, PETSC_MAX_INT);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::create_matrix(Mat *matrix) const {
  PetscInt rows = 0;
  PetscFunctionBeginUser;
  for (std::size_t dof = 0; dof < global_dofs_.size(); ++dof) {
    rows += mesh_->owned[dof / 3] && global_dofs_[dof] >= 0;
  }
  PetscCall(MatCreate(PetscObjectComm(reinterpret_cast<PetscObject>(mesh_->dm)), matrix));
  PetscCall(MatSetSizes(*matrix, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE));
  PetscCall(MatSetBlockSize(*matrix, block_size_));
  PetscCall(MatSetType(*matrix, MATAIJ));
  PetscCall(set_pattern({}, *matrix));
  PetscCall(attach_rigid_body_modes(*matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Discretization::set_pattern(const VertexPairs &pairs, Mat matrix) const {
  std::vector<PetscInt> start, column;
  PetscFunctionBeginUser;
  PetscCall(row_pattern(pairs, &start, &column));
  // Of the two, the one for the type that the matrix has takes effect. Values: zeros.
  PetscCall(MatSeqAIJSetPreallocationCSR(matrix, start.data(), column.data(), nullptr));
  PetscCall(MatMPIAIJSetPreallocationCSR(matrix, start.data(), column.data(), nullptr));
  PetscCall(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
  PetscCall(MatSetOption(matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  PetscFunctionReturn(PETSC_SUCCESS);
}

double rigid_body_mode(int m, int i, const double *p, const std::array<double, 3> &centre) {
  if (m < 3) return m == i ? 1 : 0;
  const int axis = m - 3, next = (axis + 1) % 3, after = (axis + 2) % 3;
  // e_axis x (p - centre)
  if (i == after) return p[next] - centre[static_cast<std::size_t>(next)];
  if (i == next) return -(p[after] - centre[static_cast<std::size_t>(after)]);
  return 0;
}

/// Algebraic multigrid needs to know what costs no elastic energy.
PetscErrorCode Discretization::attach_rigid_body_modes(Mat matrix) const {
  const Mesh &mesh = *mesh_;
  Vec local = nullptr;
  std::vector<Vec> modes;
  std::array<double, 3> centre{};
  PetscFunctionBeginUser;
  for (std::size_t i = 0; i < 3; ++i) centre[i] = 0.5 * (mesh.box_min[i] + mesh.box_max[i]);
  PetscCall(DMGetLocalVector(mesh.dm, &local));
  for (int m = 0; m < 6; ++m) {
    PetscScalar *value = nullptr;
    Vec mode = nullptr;
    PetscCall(VecGetArrayWrite(local, &value));
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      for (int i = 0; i < 3; ++i) {
        value[3 * v + static_cast<std::size_t>(i)] =
            rigid_body_mode(m, i, &mesh.coordinates[3 * v], centre);
      }
    }
    turn_to_axes(value);
    PetscCall(VecRestoreArrayWrite(local, &value));
    PetscCall(create_vector(&mode));
    PetscCall(DMLocalToGlobal(mesh.dm, local, INSERT_VALUES, mode));
    modes.push_back(mode);
  }
  PetscCall(DMRestoreLocalVector(mesh.dm, &local));
  PetscCall(attach_near_null_space(matrix, &modes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
