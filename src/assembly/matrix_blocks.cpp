#include "assembly/matrix_blocks.hpp"

#include <petsc/private/petscimpl.h>

#include <petscsf.h>

#include <algorithm>
#include <limits>
#include <tuple>

#include "support/petsc_compatibility.hpp"

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

/// Adds a block, given row by row.
void add_block(const BlockPlace &place, std::size_t dim, const std::vector<std::int32_t> &numbers,
               const double *block, double *const arrays[3]) {
  if (place.stride > 0) {
    double *to = arrays[place.code & 3] + (place.code >> 2);
    for (std::size_t i = 0; i < dim; ++i, to += place.stride) {
      for (std::size_t k = 0; k < dim; ++k) to[k] += *block++;
    }
  } else {
    const std::int32_t *code = numbers.data() + (place.code >> 2);
    for (std::size_t k = 0; k < dim * dim; ++k) {
      if (code[k] >= 0) arrays[code[k] & 3][code[k] >> 2] += block[k];
    }
  }
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

bool MatrixBlocks::Block::operator<(const Block &other) const {
  return std::make_tuple(free_dof(rows), rows, columns) <
         std::make_tuple(free_dof(other.rows), other.rows, other.columns);
}

MatrixBlocks::~MatrixBlocks() {
  static_cast<void>(PetscSFDestroy(&exchange_));  // errors have nowhere to go from here
  if (block_type_ != MPI_DATATYPE_NULL) MPI_Type_free(&block_type_);
}

/// Copies the rows' structure and the global numbers of the other ranks' columns.
PetscErrorCode MatrixBlocks::find_rows(Mat matrix) {
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

/// Where the number of this rank's `row` and of `column` lies.
PetscErrorCode MatrixBlocks::place_number(PetscInt row, PetscInt column, std::int32_t *code) const {
  const bool own = is_mine(column);
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

/// Where a block of this rank's rows goes, as a whole or number by number.
PetscErrorCode MatrixBlocks::place_own(const Block &block, std::vector<std::int32_t> *numbers,
                                       BlockPlace *place) const {
  PetscFunctionBeginUser;
  bool whole = true;
  for (std::size_t i = 0; i < dim_; ++i) {
    whole = whole && block.rows[i] >= 0 && block.columns[i] >= 0;
  }
  if (whole) {
    PetscCall(place_number(block.rows[0], block.columns[0], &place->code));
    const auto &start = start_[place->code & 3];
    const auto r = static_cast<std::size_t>(block.rows[0] - row_begin_);
    place->stride = start[r + 1] - start[r];
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(encode(numbers->size(), own_columns, &place->code));
  place->stride = 0;
  for (std::size_t i = 0; i < dim_; ++i) {
    for (std::size_t k = 0; k < dim_; ++k) {
      std::int32_t code = -1;
      if (block.rows[i] >= 0 && block.columns[k] >= 0) {
        PetscCall(place_number(block.rows[i], block.columns[k], &code));
      }
      numbers->push_back(code);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MatrixBlocks::place(PetscInt row, PetscInt column,
                                   std::vector<std::int32_t> *numbers, BlockPlace *place) const {
  const Block block{discretization_->dofs_of_vertex(row), discretization_->dofs_of_vertex(column)};
  PetscFunctionBeginUser;
  *place = {};
  if (free_dof(block.rows) < 0 || free_dof(block.columns) < 0) PetscFunctionReturn(PETSC_SUCCESS);
  if (is_mine(free_dof(block.rows))) {
    PetscCall(place_own(block, numbers, place));
  } else {  // blocks for others lie one after the other
    const auto found = std::lower_bound(outgoing_.begin(), outgoing_.end(), block);
    PetscCall(encode(dim_ * dim_ * static_cast<std::size_t>(found - outgoing_.begin()), for_others,
                     &place->code));
    place->stride = static_cast<std::int32_t>(dim_);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The blocks of this rank's cells whose rows others own, by owner.
void MatrixBlocks::collect_outgoing() {
  const Mesh &mesh = discretization_->mesh();
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    for (std::size_t a = 0; a < width; ++a) {
      const Dofs rows = discretization_->dofs_of_vertex(mesh.cells[c + a]);
      if (free_dof(rows) < 0 || is_mine(free_dof(rows))) continue;
      for (std::size_t b = 0; b < width; ++b) {
        const Dofs columns = discretization_->dofs_of_vertex(mesh.cells[c + b]);
        if (free_dof(columns) >= 0) outgoing_.push_back({rows, columns});
      }
    }
  }
  std::sort(outgoing_.begin(), outgoing_.end());
  outgoing_.erase(std::unique(outgoing_.begin(), outgoing_.end(),
                              [](const Block &a, const Block &b) { return !(a < b); }),
                  outgoing_.end());
  outgoing_count_ = outgoing_.size();
}

PetscErrorCode MatrixBlocks::begin_placing(const Discretization &discretization, Mat matrix) {
  MatInfo info;
  PetscFunctionBeginUser;
  discretization_ = &discretization;
  dim_ = static_cast<std::size_t>(discretization.mesh().dimension());
  comm_ = PetscObjectComm(reinterpret_cast<PetscObject>(matrix));
  PetscCall(MatGetInfo(matrix, MAT_LOCAL, &info));
  numbers_ = info.nz_used;
  PetscCall(find_rows(matrix));
  collect_outgoing();
  PetscFunctionReturn(PETSC_SUCCESS);
}

double MatrixBlocks::bytes() const {
  return static_cast<double>(incoming_.capacity() * sizeof(BlockPlace) +
                             incoming_numbers_.capacity() * sizeof(std::int32_t));
}

PetscErrorCode MatrixBlocks::begin(Mat matrix, Target *target) const {
  Mat parts[2];
  PetscFunctionBeginUser;
  MatInfo info;
  PetscCall(MatGetInfo(matrix, MAT_LOCAL, &info));
  PetscCheck(info.nz_used == numbers_, PETSC_COMM_SELF, PETSC_ERR_PLIB,
             "places were found in a matrix of another pattern");
  target->matrix = matrix;
  PetscCall(MatZeroEntries(matrix));
  PetscCall(parts_of(matrix, parts, nullptr));
  for (int p = 0; p < 2; ++p) {
    if (parts[p]) PetscCall(MatSeqAIJGetArray(parts[p], &target->arrays[p]));
  }
  target->outgoing.assign(dim_ * dim_ * outgoing_count_, 0);
  target->arrays[for_others] = target->outgoing.data();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode MatrixBlocks::end(Target *target) const {
  std::vector<double> received(dim_ * dim_ * incoming_.size(), 0);
  Mat parts[2];
  PetscFunctionBeginUser;
  PetscCall(PetscSFReduceBegin(exchange_, block_type_, target->outgoing.data(), received.data(),
                               MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(exchange_, block_type_, target->outgoing.data(), received.data(),
                             MPI_REPLACE));
  const double *block = received.data();
  for (const BlockPlace &place : incoming_) {
    add_block(place, dim_, incoming_numbers_, block, target->arrays);
    block += dim_ * dim_;
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
