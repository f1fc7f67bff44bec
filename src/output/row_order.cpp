#include "output/row_order.hpp"

#include <algorithm>
#include <numeric>

#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// A star forest from items that name places to the owners of these places.
PetscErrorCode make_forest(MPI_Comm comm, PetscLayout layout, const std::vector<PetscInt> &places,
                           PetscSF *forest) {
  PetscFunctionBeginUser;
  PetscCall(PetscSFCreate(comm, forest));
  PetscCall(PetscSFSetGraphLayout(*forest, layout, static_cast<PetscInt>(places.size()), nullptr,
                                  PETSC_OWN_POINTER, places.data()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

RowOrder::~RowOrder() {
  static_cast<void>(PetscSFDestroy(&to_rows_));  // errors have nowhere to go from here
  static_cast<void>(PetscLayoutDestroy(&by_number_));
}

PetscErrorCode RowOrder::set_up(MPI_Comm comm, const std::vector<PetscInt> &numbers) {
  PetscLayout layout = nullptr;
  std::vector<PetscInt> places(numbers);
  PetscFunctionBeginUser;
  comm_ = comm;
  total_ = static_cast<PetscInt>(numbers.size());
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &total_, 1, MPIU_INT, MPI_SUM, comm));
  PetscCall(close_gaps(numbers, &places));
  PetscCall(PetscLayoutCreateFromSizes(comm, PETSC_DECIDE, total_, 1, &layout));
  PetscCall(PetscLayoutGetLocalSize(layout, &share_));
  PetscCall(PetscLayoutGetRange(layout, &first_, nullptr));
  PetscCall(make_forest(comm, layout, places, &to_rows_));
  PetscCall(PetscLayoutDestroy(&layout));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Marks the numbers that there are, on the ranks that own an even share of all of them, and
/// counts.
PetscErrorCode RowOrder::close_gaps(const std::vector<PetscInt> &numbers,
                                    std::vector<PetscInt> *places) {
  PetscSF forest = nullptr;
  PetscInt ends[2] = {0, 0}, share = 0, begin = 0;  // highest number, negated lowest
  PetscFunctionBeginUser;
  for (const PetscInt number : numbers) {
    ends[0] = std::max(ends[0], number);
    ends[1] = std::max(ends[1], -number);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPIU_INT, MPI_MAX, comm_));
  PetscCheck(ends[1] <= 0, comm_, PETSC_ERR_ARG_SIZ, "rows are numbered from 0");
  PetscCall(PetscLayoutCreateFromSizes(comm_, PETSC_DECIDE, ends[0] + 1, 1, &by_number_));
  PetscCall(PetscLayoutGetLocalSize(by_number_, &share));
  PetscCall(make_forest(comm_, by_number_, numbers, &forest));
  std::vector<PetscInt> one(numbers.size(), 1), count(static_cast<std::size_t>(share), 0);
  PetscCall(PetscSFReduceBegin(forest, MPIU_INT, one.data(), count.data(), MPI_SUM));
  PetscCall(PetscSFReduceEnd(forest, MPIU_INT, one.data(), count.data(), MPI_SUM));
  PetscMPIInt twice = std::any_of(count.begin(), count.end(), [](PetscInt c) { return c > 1; });
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &twice, 1, MPI_INT, MPI_MAX, comm_));
  if (!twice && ends[0] + 1 > total_) {
    const PetscInt mine = std::accumulate(count.begin(), count.end(), PetscInt{0});
    PetscCallMPI(MPI_Exscan(&mine, &begin, 1, MPIU_INT, MPI_SUM, comm_));
    place_of_number_.resize(count.size());
    std::exclusive_scan(count.begin(), count.end(), place_of_number_.begin(), begin);
    PetscCall(
        PetscSFBcastBegin(forest, MPIU_INT, place_of_number_.data(), places->data(), MPI_REPLACE));
    PetscCall(
        PetscSFBcastEnd(forest, MPIU_INT, place_of_number_.data(), places->data(), MPI_REPLACE));
  } else {
    PetscCall(PetscLayoutDestroy(&by_number_));
  }
  PetscCall(PetscSFDestroy(&forest));
  PetscCheck(!twice, comm_, PETSC_ERR_ARG_SIZ, "a row's number is given twice");
  PetscFunctionReturn(PETSC_SUCCESS);
}

template <class T>
PetscErrorCode RowOrder::arrange(MPI_Datatype type, const std::vector<T> &values, int width,
                                 std::vector<T> *rows) const {
  MPI_Datatype row = MPI_DATATYPE_NULL;
  PetscFunctionBeginUser;
  rows->resize(static_cast<std::size_t>(share_) * static_cast<std::size_t>(width));
  PetscCallMPI(MPI_Type_contiguous(width, type, &row));
  PetscCallMPI(MPI_Type_commit(&row));
  PetscCall(PetscSFReduceBegin(to_rows_, row, values.data(), rows->data(), MPI_REPLACE));
  PetscCall(PetscSFReduceEnd(to_rows_, row, values.data(), rows->data(), MPI_REPLACE));
  PetscCallMPI(MPI_Type_free(&row));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RowOrder::arrange(const std::vector<double> &values, int width,
                                 std::vector<double> *rows) const {
  PetscFunctionBeginUser;
  PetscCall(arrange(MPI_DOUBLE, values, width, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RowOrder::arrange(const std::vector<PetscInt> &values, int width,
                                 std::vector<PetscInt> *rows) const {
  PetscFunctionBeginUser;
  PetscCall(arrange(MPIU_INT, values, width, rows));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RowOrder::fetch(const std::vector<PetscInt> &numbers,
                               const std::vector<double> &rows, int width,
                               std::vector<double> *values) const {
  PetscLayout layout = nullptr;
  PetscSF forest = nullptr;
  MPI_Datatype row = MPI_DATATYPE_NULL;
  std::vector<PetscInt> places(numbers);
  PetscFunctionBeginUser;
  PetscCall(find_places(&places));
  PetscCall(PetscLayoutCreateFromSizes(comm_, share_, total_, 1, &layout));
  PetscCall(make_forest(comm_, layout, places, &forest));
  PetscCall(PetscLayoutDestroy(&layout));
  values->resize(numbers.size() * static_cast<std::size_t>(width));
  PetscCallMPI(MPI_Type_contiguous(width, MPI_DOUBLE, &row));
  PetscCallMPI(MPI_Type_commit(&row));
  PetscCall(PetscSFBcastBegin(forest, row, rows.data(), values->data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(forest, row, rows.data(), values->data(), MPI_REPLACE));
  PetscCallMPI(MPI_Type_free(&row));
  PetscCall(PetscSFDestroy(&forest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode RowOrder::find_places(std::vector<PetscInt> *numbers) const {
  PetscSF forest = nullptr;
  PetscFunctionBeginUser;
  if (!by_number_) PetscFunctionReturn(PETSC_SUCCESS);
  std::vector<PetscInt> wanted(*numbers);
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  std::vector<PetscInt> places(wanted.size());
  PetscCall(make_forest(comm_, by_number_, wanted, &forest));
  PetscCall(
      PetscSFBcastBegin(forest, MPIU_INT, place_of_number_.data(), places.data(), MPI_REPLACE));
  PetscCall(PetscSFBcastEnd(forest, MPIU_INT, place_of_number_.data(), places.data(), MPI_REPLACE));
  PetscCall(PetscSFDestroy(&forest));
  for (PetscInt &number : *numbers) {
    const auto found = std::lower_bound(wanted.begin(), wanted.end(), number);
    number = places[static_cast<std::size_t>(found - wanted.begin())];
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
