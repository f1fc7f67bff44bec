#include "assembly/direct_assembly.hpp"

#include <petsc/private/petscimpl.h>

#include <petscsf.h>

#include <algorithm>
#include <numeric>

#include "petsc_compatibility.hpp"

namespace trefoil {
namespace {

// The arrays that BlockPlaces chooses from.
enum Region { own_columns = 0, other_columns = 1, for_others = 2, held = 3 };

std::int32_t code_of(std::size_t place, Region region) {
  return static_cast<std::int32_t>(4 * place + region);
}

/// The parts of an AIJ matrix: own columns and, with several ranks, the others'.
PetscErrorCode parts_of(Mat matrix, Mat (&parts)[2], const PetscInt **ghost_columns) {
  PetscBool sequential = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(matrix), MATSEQAIJ, &sequential));
  parts[0] = matrix;
  parts[1] = nullptr;
  if (!sequential) PetscCall(MatMPIAIJGetSeqAIJ(matrix, &parts[0], &parts[1], ghost_columns));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

DirectAssembly::~DirectAssembly() {
  static_cast<void>(PetscSFDestroy(&exchange_));  // errors have nowhere to go from here
  if (block_type_ != MPI_DATATYPE_NULL) MPI_Type_free(&block_type_);
}

/// Copies the rows' structure and the global numbers of the other ranks' columns.
PetscErrorCode DirectAssembly::find_rows(Mat matrix) {
  Mat parts[2];
  const PetscInt *ghosts = nullptr, *ranges = nullptr;
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCall(parts_of(matrix, parts, &ghosts));
  for (int p = 0; p < 2; ++p) {
    PetscInt rows = 0;
    const PetscInt *start = nullptr, *column = nullptr;
    PetscBool done = PETSC_FALSE;
    if (!parts[p]) continue;
    PetscCall(MatGetRowIJ(parts[p], 0, PETSC_FALSE, PETSC_FALSE, &rows, &start, &column, &done));
    start_[p].assign(start, start + rows + 1);
    column_[p].assign(column, column + start[rows]);
    PetscCall(
        MatRestoreRowIJ(parts[p], 0, PETSC_FALSE, PETSC_FALSE, &rows, &start, &column, &done));
  }
  if (parts[1]) {
    PetscInt columns = 0;
    PetscCall(MatGetSize(parts[1], nullptr, &columns));
    ghost_columns_.assign(ghosts, ghosts + columns);
  }
  PetscCallMPI(MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), &ranks));
  PetscCall(MatGetOwnershipRanges(matrix, &ranges));
  row_ranges_.assign(ranges, ranges + ranks + 1);
  PetscCall(MatGetOwnershipRange(matrix, &row_begin_, &row_end_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where the block of this rank's `row` and of `column`, both first of a vertex, begins.
PetscErrorCode DirectAssembly::place_block(PetscInt row, PetscInt column,
                                           std::int32_t *code) const {
  const bool own = column >= row_begin_ && column < row_end_;
  const int p = own ? 0 : 1;
  PetscFunctionBeginUser;
  PetscInt local = column - row_begin_;
  if (!own) {
    const auto found = std::lower_bound(ghost_columns_.begin(), ghost_columns_.end(), column);
    local = static_cast<PetscInt>(found - ghost_columns_.begin());
  }
  const auto begin = column_[p].begin() + start_[p][static_cast<std::size_t>(row - row_begin_)];
  const auto end = column_[p].begin() + start_[p][static_cast<std::size_t>(row - row_begin_ + 1)];
  const auto found = std::lower_bound(begin, end, local);
  PetscCheck(found != end && *found == local, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "the matrix has no entry (%" PetscInt_FMT ", %" PetscInt_FMT ")", row, column);
  *code = code_of(static_cast<std::size_t>(found - column_[p].begin()),
                  own ? own_columns : other_columns);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DirectAssembly::set_up(const Discretization &discretization, Mat matrix) {
  const Mesh &mesh = discretization.mesh();
  const auto &dofs = discretization.global_dofs();
  PetscFunctionBeginUser;
  PetscCall(find_rows(matrix));
  const auto first_dof = [&](PetscInt v) { return dofs[static_cast<std::size_t>(3 * v)]; };
  const auto is_mine = [&](PetscInt dof) { return dof >= row_begin_ && dof < row_end_; };

  std::vector<Remote> outgoing;
  for (std::size_t c = 0; c + 3 < mesh.cells.size(); c += 4) {
    for (std::size_t a = 0; a < 4; ++a) {
      const PetscInt row = first_dof(mesh.cells[c + a]);
      if (row < 0 || is_mine(row)) continue;
      for (std::size_t b = 0; b < 4; ++b) {
        const PetscInt column = first_dof(mesh.cells[c + b]);
        if (column >= 0) outgoing.push_back({row, column});
      }
    }
  }
  std::sort(outgoing.begin(), outgoing.end());
  outgoing.erase(std::unique(outgoing.begin(), outgoing.end(),
                             [](const Remote &a, const Remote &b) { return !(a < b); }),
                 outgoing.end());

  places_.code.assign(4 * mesh.cells.size(), code_of(0, held));
  for (std::size_t c = 0; c + 3 < mesh.cells.size(); c += 4) {
    for (std::size_t a = 0; a < 4; ++a) {
      const PetscInt row = first_dof(mesh.cells[c + a]);
      for (std::size_t b = 0; b < 4 && row >= 0; ++b) {
        const PetscInt column = first_dof(mesh.cells[c + b]);
        if (column < 0) continue;
        std::int32_t &code = places_.code[4 * c + 4 * a + b];
        if (is_mine(row)) {
          PetscCall(place_block(row, column, &code));
        } else {
          const auto found =
              std::lower_bound(outgoing.begin(), outgoing.end(), Remote{row, column});
          code = code_of(9 * static_cast<std::size_t>(found - outgoing.begin()), for_others);
        }
      }
    }
  }
  places_.stride.assign(static_cast<std::size_t>(4 * mesh.local_vertices()), 3);
  for (PetscInt v = 0; v < mesh.local_vertices(); ++v) {
    const PetscInt row = first_dof(v);
    if (row < 0 || !is_mine(row)) continue;
    for (std::size_t p = 0; p < 2; ++p) {
      if (start_[p].empty()) continue;
      const auto r = static_cast<std::size_t>(row - row_begin_);
      places_.stride[4 * static_cast<std::size_t>(v) + p] = start_[p][r + 1] - start_[p][r];
    }
  }
  PetscCall(connect(PetscObjectComm(reinterpret_cast<PetscObject>(matrix)), outgoing));
  for (int p = 0; p < 2; ++p) start_[p] = column_[p] = {};
  ghost_columns_ = {};
  ready_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tells the owners which blocks come to them; they find the places.
PetscErrorCode DirectAssembly::connect(MPI_Comm comm, const std::vector<Remote> &outgoing) {
  const std::size_t ranks = row_ranges_.size() - 1;
  PetscFunctionBeginUser;
  outgoing_count_ = outgoing.size();
  std::vector<PetscMPIInt> send(ranks, 0), receive(ranks, 0), send_at(ranks, 0),
      receive_at(ranks, 0);
  std::vector<PetscInt> numbers;  // sorted by row, so by owner
  for (const Remote &block : outgoing) {
    const auto owner = std::upper_bound(row_ranges_.begin(), row_ranges_.end(), block.row) -
                       row_ranges_.begin() - 1;
    send[static_cast<std::size_t>(owner)] += 2;
    numbers.push_back(block.row);
    numbers.push_back(block.column);
  }
  PetscCallMPI(MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm));
  std::exclusive_scan(send.begin(), send.end(), send_at.begin(), 0);
  std::exclusive_scan(receive.begin(), receive.end(), receive_at.begin(), 0);
  std::vector<PetscInt> arrived(static_cast<std::size_t>(receive_at.back() + receive.back()));
  PetscCallMPI(MPI_Alltoallv(numbers.data(), send.data(), send_at.data(), MPIU_INT, arrived.data(),
                             receive.data(), receive_at.data(), MPIU_INT, comm));
  for (std::size_t i = 0; i < arrived.size(); i += 2) {
    std::int32_t code = 0;
    PetscCall(place_block(arrived[i], arrived[i + 1], &code));
    incoming_.push_back(code);
    const auto r = static_cast<std::size_t>(arrived[i] - row_begin_);
    const auto &start = start_[code & 3];
    incoming_stride_.push_back(start[r + 1] - start[r]);
  }
  // A sender's first block lies at the owner behind those of the ranks before it.
  std::vector<PetscMPIInt> offset_at_owner(ranks, 0);
  PetscCallMPI(
      MPI_Alltoall(receive_at.data(), 1, MPI_INT, offset_at_owner.data(), 1, MPI_INT, comm));
  std::vector<PetscSFNode> destination;
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    for (PetscMPIInt i = 0; i < send[rank] / 2; ++i) {
      PetscSFNode node;
      node.rank = static_cast<decltype(node.rank)>(rank);
      node.index = offset_at_owner[rank] / 2 + i;
      destination.push_back(node);
    }
  }
  PetscCall(PetscSFCreate(comm, &exchange_));
  PetscCall(PetscSFSetGraph(exchange_, static_cast<PetscInt>(incoming_.size()),
                            static_cast<PetscInt>(destination.size()), nullptr, PETSC_COPY_VALUES,
                            destination.data(), PETSC_COPY_VALUES));
  PetscCall(PetscSFSetUp(exchange_));
  PetscCallMPI(MPI_Type_contiguous(9, MPI_DOUBLE, &block_type_));
  PetscCallMPI(MPI_Type_commit(&block_type_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DirectAssembly::begin(Mat matrix, Target *target) const {
  static thread_local double nowhere[9];  // blocks of held vertices end here
  Mat parts[2];
  PetscFunctionBeginUser;
  target->matrix = matrix;
  PetscCall(MatZeroEntries(matrix));
  PetscCall(parts_of(matrix, parts, nullptr));
  for (int p = 0; p < 2; ++p) {
    if (parts[p]) PetscCall(MatSeqAIJGetArray(parts[p], &target->arrays[p]));
  }
  target->outgoing.assign(9 * outgoing_count_, 0);
  target->arrays[for_others] = target->outgoing.data();
  target->arrays[held] = nowhere;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DirectAssembly::end(Target *target) const {
  std::vector<double> received(9 * incoming_.size(), 0);
  Mat parts[2];
  PetscFunctionBeginUser;
  PetscCall(PetscSFReduceBegin(exchange_, block_type_, target->outgoing.data(), received.data(),
                               MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(exchange_, block_type_, target->outgoing.data(), received.data(),
                             MPI_REPLACE));
  for (std::size_t block = 0; block < incoming_.size(); ++block) {
    double *to = target->arrays[incoming_[block] & 3] + (incoming_[block] >> 2);
    for (std::size_t i = 0; i < 3; ++i, to += incoming_stride_[block]) {
      for (std::size_t k = 0; k < 3; ++k) to[k] += received[9 * block + 3 * i + k];
    }
  }
  PetscCall(parts_of(target->matrix, parts, nullptr));
  for (int p = 0; p < 2; ++p) {
    if (parts[p]) PetscCall(MatSeqAIJRestoreArray(parts[p], &target->arrays[p]));
  }
  // Values written into the parts do not show on the whole, and a solver would keep its old factor.
  PetscCall(MatAssemblyBegin(target->matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(target->matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(PetscObjectStateIncrease(reinterpret_cast<PetscObject>(target->matrix)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
