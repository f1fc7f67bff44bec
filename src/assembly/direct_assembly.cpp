#include "assembly/direct_assembly.hpp"

#include <petsc/private/petscimpl.h>

#include <petscsf.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "petsc_compatibility.hpp"

namespace trefoil {
namespace {

// The arrays that BlockPlace chooses from.
enum Region { own_columns = 0, other_columns = 1, for_others = 2 };

/// A place and its array as BlockPlace codes them.
PetscErrorCode encode(std::size_t place, Region region, std::int32_t *code) {
  PetscFunctionBeginUser;
  PetscCheck(place <= std::numeric_limits<std::int32_t>::max() / 4, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "the matrix has more than 536870911 numbers on one rank; run on more ranks");
  *code = static_cast<std::int32_t>(4 * place + region);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Any of a vertex's dofs that is free; -1 if all are held.
template <class Dofs>
PetscInt free_dof(const Dofs &dofs) {
  return *std::max_element(dofs.begin(), dofs.end());
}

template <class Dofs>
bool wholly_free(const Dofs &dofs) {
  return *std::min_element(dofs.begin(), dofs.end()) >= 0;
}

/// By owner first.
template <class Remote>
auto key_of(const Remote &block) {
  return std::make_tuple(free_dof(block.rows), block.rows, block.columns);
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

bool DirectAssembly::is_mine(const Dofs &rows) const {
  const PetscInt row = free_dof(rows);
  return row >= row_begin_ && row < row_end_;
}

/// Where the number of this rank's `row` and of `column` lies.
PetscErrorCode DirectAssembly::place_number(PetscInt row, PetscInt column,
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
  PetscCall(encode(static_cast<std::size_t>(found - column_[p].begin()),
                   own ? own_columns : other_columns, code));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Where a block goes; nowhere if all its rows or columns are held.
PetscErrorCode DirectAssembly::place_block(const Dofs &rows, const Dofs &columns,
                                           BlockPlace *place) {
  PetscFunctionBeginUser;
  *place = {};
  if (free_dof(rows) < 0 || free_dof(columns) < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (!is_mine(rows)) {
    const Remote block{rows, columns};
    const auto found =
        std::lower_bound(outgoing_.begin(), outgoing_.end(), block,
                         [](const Remote &a, const Remote &b) { return key_of(a) < key_of(b); });
    PetscCall(
        encode(9 * static_cast<std::size_t>(found - outgoing_.begin()), for_others, &place->code));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (wholly_free(rows) && wholly_free(columns)) {
    PetscCall(place_number(rows[0], columns[0], &place->code));
    const auto &start = start_[place->code & 3];
    const auto r = static_cast<std::size_t>(rows[0] - row_begin_);
    place->stride = start[r + 1] - start[r];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(encode(sums_.numbers.size() / 9, own_columns, &place->code));
  place->stride = 0;
  for (const PetscInt row : rows) {
    for (const PetscInt column : columns) {
      std::int32_t code = -1;
      if (row >= 0 && column >= 0) PetscCall(place_number(row, column, &code));
      sums_.numbers.push_back(code);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The blocks of this rank's elements whose rows others own, by owner.
PetscErrorCode DirectAssembly::collect_remote(const Discretization &discretization) {
  const Mesh &mesh = discretization.mesh();
  PetscFunctionBeginUser;
  for (std::size_t c = 0; c + 3 < mesh.cells.size(); c += 4) {
    for (std::size_t a = 0; a < 4; ++a) {
      const Dofs rows = discretization.dofs_of_vertex(mesh.cells[c + a]);
      if (free_dof(rows) < 0 || is_mine(rows)) continue;
      for (std::size_t b = 0; b < 4; ++b) {
        const Dofs columns = discretization.dofs_of_vertex(mesh.cells[c + b]);
        if (free_dof(columns) >= 0) outgoing_.push_back({rows, columns});
      }
    }
  }
  std::sort(outgoing_.begin(), outgoing_.end(),
            [](const Remote &a, const Remote &b) { return key_of(a) < key_of(b); });
  outgoing_.erase(
      std::unique(outgoing_.begin(), outgoing_.end(),
                  [](const Remote &a, const Remote &b) { return key_of(a) == key_of(b); }),
      outgoing_.end());
  outgoing_count_ = outgoing_.size();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode DirectAssembly::set_up(const Discretization &discretization, const Tet4Packs &tets,
                                      Mat matrix) {
  PetscFunctionBeginUser;
  PetscCall(find_rows(matrix));
  PetscCall(collect_remote(discretization));
  const auto place = [&](PetscInt row, PetscInt column, BlockPlace *result) {
    return place_block(discretization.dofs_of_vertex(row), discretization.dofs_of_vertex(column),
                       result);
  };
  PetscCall(make_block_sums(tets, place, &sums_));
  PetscCall(connect(PetscObjectComm(reinterpret_cast<PetscObject>(matrix))));
  for (int p = 0; p < 2; ++p) start_[p] = column_[p] = {};
  ghost_columns_ = {};
  outgoing_ = {};
  ready_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tells the owners which blocks come to them; they find the places.
PetscErrorCode DirectAssembly::connect(MPI_Comm comm) {
  const std::size_t ranks = row_ranges_.size() - 1;
  constexpr PetscMPIInt length = 6;  // of a block's numbers
  PetscFunctionBeginUser;
  std::vector<PetscMPIInt> send(ranks, 0), receive(ranks, 0), send_at(ranks, 0),
      receive_at(ranks, 0);
  std::vector<PetscInt> numbers;
  for (const Remote &block : outgoing_) {
    const auto owner =
        std::upper_bound(row_ranges_.begin(), row_ranges_.end(), free_dof(block.rows)) -
        row_ranges_.begin() - 1;
    send[static_cast<std::size_t>(owner)] += length;
    numbers.insert(numbers.end(), block.rows.begin(), block.rows.end());
    numbers.insert(numbers.end(), block.columns.begin(), block.columns.end());
  }
  PetscCallMPI(MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm));
  std::exclusive_scan(send.begin(), send.end(), send_at.begin(), 0);
  std::exclusive_scan(receive.begin(), receive.end(), receive_at.begin(), 0);
  std::vector<PetscInt> arrived(static_cast<std::size_t>(receive_at.back() + receive.back()));
  PetscCallMPI(MPI_Alltoallv(numbers.data(), send.data(), send_at.data(), MPIU_INT, arrived.data(),
                             receive.data(), receive_at.data(), MPIU_INT, comm));
  for (std::size_t i = 0; i < arrived.size(); i += length) {
    BlockPlace place;
    PetscCall(place_block({arrived[i], arrived[i + 1], arrived[i + 2]},
                          {arrived[i + 3], arrived[i + 4], arrived[i + 5]}, &place));
    incoming_.push_back(place);
  }
  // A sender's first block lies at the owner behind those of the ranks before it.
  std::vector<PetscMPIInt> offset_at_owner(ranks, 0);
  PetscCallMPI(
      MPI_Alltoall(receive_at.data(), 1, MPI_INT, offset_at_owner.data(), 1, MPI_INT, comm));
  std::vector<PetscSFNode> destination;
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    for (PetscMPIInt i = 0; i < send[rank] / length; ++i) {
      PetscSFNode node;
      node.rank = static_cast<decltype(node.rank)>(rank);
      node.index = offset_at_owner[rank] / length + i;
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
    add_block<InstructionSet::baseline>(sums_, incoming_[block], false, &received[9 * block],
                                        target->arrays);
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
