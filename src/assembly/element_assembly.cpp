#include "assembly/element_assembly.hpp"

#include <petsc/private/petscimpl.h>

#include <petscsf.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "petsc_compatibility.hpp"

namespace trefoil {
namespace {

// The arrays that ElementPlaces chooses from, and what is no array.
enum Region { own_columns = 0, other_columns = 1, for_others = 2, in_parts = 3 };

PetscErrorCode encode(std::size_t place, Region region, std::int32_t *code) {
  PetscFunctionBeginUser;
  PetscCheck(place <= std::numeric_limits<std::int32_t>::max() / 4, PETSC_COMM_SELF, PETSC_ERR_SUP,
             "the matrix has more than 536870911 numbers on one rank; run on more ranks");
  *code = static_cast<std::int32_t>(4 * place + region);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Any free one; -1 where all are held.
template <class Dofs>
PetscInt free_dof(const Dofs &dofs) {
  return *std::max_element(dofs.begin(), dofs.end());
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

ElementAssembly::~ElementAssembly() {
  static_cast<void>(PetscSFDestroy(&exchange_));  // errors have nowhere to go from here
  if (block_type_ != MPI_DATATYPE_NULL) MPI_Type_free(&block_type_);
}

double ElementAssembly::bytes() const {
  return static_cast<double>(
      (places_.code.capacity() + places_.stride.capacity() + places_.numbers.capacity()) *
          sizeof(std::int32_t) +
      incoming_.capacity() * sizeof(Place));
}

/// By owner first.
bool ElementAssembly::Block::operator<(const Block &other) const {
  return std::make_tuple(free_dof(rows), rows, columns) <
         std::make_tuple(free_dof(other.rows), other.rows, other.columns);
}

ElementAssembly::Dofs ElementAssembly::dofs_of(const Discretization &discretization,
                                               PetscInt vertex) const {
  Dofs dofs{-1, -1, -1};
  for (std::size_t i = 0; i < dim_; ++i) {
    dofs[i] = discretization.global_dofs()[static_cast<std::size_t>(3 * vertex) + i];
  }
  return dofs;
}

PetscErrorCode ElementAssembly::set_up(const Discretization &discretization, Mat matrix) {
  PetscFunctionBeginUser;
  dim_ = static_cast<std::size_t>(discretization.mesh().dimension);
  PetscCall(find_rows(matrix));
  collect_outgoing(discretization);
  PetscCall(place_cells(discretization));
  PetscCall(connect(PetscObjectComm(reinterpret_cast<PetscObject>(matrix))));
  for (int p = 0; p < 2; ++p) start_[p] = column_[p] = {};
  ghost_columns_ = {};
  outgoing_ = {};
  ready_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Copies the rows' structure and the global numbers of the other ranks' columns.
PetscErrorCode ElementAssembly::find_rows(Mat matrix) {
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

/// The blocks of this rank's cells whose rows others own, by owner.
void ElementAssembly::collect_outgoing(const Discretization &discretization) {
  const Mesh &mesh = discretization.mesh();
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell);
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    for (std::size_t a = 0; a < width; ++a) {
      const Dofs rows = dofs_of(discretization, mesh.cells[c + a]);
      if (free_dof(rows) < 0 || is_mine(free_dof(rows))) continue;
      for (std::size_t b = 0; b < width; ++b) {
        const Dofs columns = dofs_of(discretization, mesh.cells[c + b]);
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

/// Where the number of this rank's `row` and of `column` lies.
PetscErrorCode ElementAssembly::place_number(PetscInt row, PetscInt column,
                                             std::int32_t *code) const {
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
PetscErrorCode ElementAssembly::place_block(const Block &block, Place *place) {
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
  PetscCall(encode(places_.numbers.size(), in_parts, &place->code));
  for (std::size_t i = 0; i < dim_; ++i) {
    for (std::size_t k = 0; k < dim_; ++k) {
      std::int32_t code = ElementPlaces::nowhere;
      if (block.rows[i] >= 0 && block.columns[k] >= 0) {
        PetscCall(place_number(block.rows[i], block.columns[k], &code));
      }
      places_.numbers.push_back(code);
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementAssembly::place_cells(const Discretization &discretization) {
  const Mesh &mesh = discretization.mesh();
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell);
  PetscFunctionBeginUser;
  places_.code.assign(width * mesh.cells.size(), ElementPlaces::nowhere);
  // Blocks for others lie row by row.
  places_.stride.assign(static_cast<std::size_t>(4 * mesh.local_vertices()),
                        static_cast<std::int32_t>(dim_));
  for (std::size_t c = 0; c < mesh.cells.size(); c += width) {
    for (std::size_t a = 0; a < width; ++a) {
      const PetscInt vertex = mesh.cells[c + a];
      const Dofs rows = dofs_of(discretization, vertex);
      for (std::size_t b = 0; b < width && free_dof(rows) >= 0; ++b) {
        const Block block{rows, dofs_of(discretization, mesh.cells[c + b])};
        if (free_dof(block.columns) < 0) continue;
        std::int32_t &code = places_.code[width * (c + a) + b];
        if (!is_mine(free_dof(rows))) {
          const auto found = std::lower_bound(outgoing_.begin(), outgoing_.end(), block);
          PetscCall(encode(dim_ * dim_ * static_cast<std::size_t>(found - outgoing_.begin()),
                           for_others, &code));
          continue;
        }
        Place place;
        PetscCall(place_block(block, &place));
        code = place.code;
        if ((code & 3) != in_parts) {
          places_.stride[static_cast<std::size_t>(4 * vertex + (code & 3))] = place.stride;
        }
      }
    }
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Tells the owners which blocks come to them; they find the places.
PetscErrorCode ElementAssembly::connect(MPI_Comm comm) {
  constexpr PetscMPIInt length = 6;  // of a block's dofs
  const std::size_t ranks = row_ranges_.size() - 1;
  PetscFunctionBeginUser;
  std::vector<PetscMPIInt> send(ranks, 0), receive(ranks, 0), send_at(ranks, 0),
      receive_at(ranks, 0);
  std::vector<PetscInt> numbers;
  for (const Block &block : outgoing_) {
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
    Place place;
    PetscCall(place_block({{arrived[i], arrived[i + 1], arrived[i + 2]},
                           {arrived[i + 3], arrived[i + 4], arrived[i + 5]}},
                          &place));
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
  PetscCallMPI(MPI_Type_contiguous(static_cast<int>(dim_ * dim_), MPI_DOUBLE, &block_type_));
  PetscCallMPI(MPI_Type_commit(&block_type_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ElementAssembly::begin(Mat matrix, Target *target) const {
  Mat parts[2];
  PetscFunctionBeginUser;
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

PetscErrorCode ElementAssembly::end(Target *target) const {
  std::vector<double> received(dim_ * dim_ * incoming_.size(), 0);
  Mat parts[2];
  PetscFunctionBeginUser;
  PetscCall(PetscSFReduceBegin(exchange_, block_type_, target->outgoing.data(), received.data(),
                               MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(exchange_, block_type_, target->outgoing.data(), received.data(),
                             MPI_REPLACE));
  const double *from = received.data();
  for (const Place &place : incoming_) {
    places_.add(place.code, place.stride, dim_, from, 1, target->arrays);
    from += dim_ * dim_;
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
