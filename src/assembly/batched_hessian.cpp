#include "assembly/batched_hessian.hpp"

#include <petsctime.h>

#include <algorithm>

#include "assembly/element_places.hpp"
#include "filter/reduced_filter.hpp"
#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/packed_elements.hpp"

namespace trefoil {
namespace {

/// Packs worked on at a time: their matrices stay in the second-level cache, and the filter has
/// enough of them to sort by the number of negative eigenvalues.
constexpr PetscInt chunk = 64;
static_assert(chunk % BlockSums::stretch == 0);

/// The same in memory for larger matrices.
PetscInt chunk_of(const PackedElements &elements) {
  return std::max<PetscInt>(8, chunk * reduced_entries / elements.entries());
}

/// Memory of one chunk.
struct Workspace {
  std::vector<double> K = std::vector<double>(chunk * reduced_entries * lanes);
  std::vector<double> N = std::vector<double>(chunk * reduced_entries * lanes);
  std::vector<int> negative = std::vector<int>(chunk * lanes);
};

/// Splits a chunk's matrices and counts the indefinite ones, copies that fill the last pack aside.
template <class Split>
PetscErrorCode filter(const Split &split_chunk, TrefoilSplitStatistics *statistics) {
  PetscLogDouble begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(event_filter, nullptr, nullptr, nullptr, nullptr));
  PetscCall(PetscTime(&begin));
  const SplitResult result = split_chunk();
  PetscCall(PetscTime(&end));
  PetscCall(PetscLogEventEnd(event_filter, nullptr, nullptr, nullptr, nullptr));
  PetscCheck(result.status == SplitStatus::ok || result.status == SplitStatus::not_finite,
             PETSC_COMM_SELF, PETSC_ERR_LIB, "no eigenvalues of an element Hessian were found");
  statistics->filter_seconds += end - begin;
  statistics->indefinite += result.indefinite;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode filter(Workspace &work, PetscInt packs, TrefoilSplitStatistics *statistics) {
  PetscFunctionBeginUser;
  PetscCall(filter(
      [&] {
        return split_reduced(static_cast<int>(packs), work.K.data(), work.N.data(),
                             work.negative.data());
      },
      statistics));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds up H (may be null) and N (may be null) of linear tetrahedra.
PetscErrorCode assemble_tets(const Term &term, const double *u, const BlockSums &sums,
                             double *const *H, double *const *N, bool filtering,
                             TrefoilSplitStatistics *statistics) {
  static const AddBlocks add_blocks = add_blocks_kernel();
  static thread_local Workspace work;
  const Tet4Packs &tets = *term.packs();
  PetscFunctionBeginUser;
  for (PetscInt first = 0; first < tets.packs(); first += chunk) {
    const PetscInt count = std::min(chunk, tets.packs() - first);
    term.reduced_hessians(first, count, u, work.K.data());
    if (H) add_blocks(sums, first, count, work.K.data(), nullptr, H);
    if (!filtering) continue;
    PetscCall(filter(work, count, statistics));
    if (N) add_blocks(sums, first, count, work.N.data(), work.negative.data(), N);
  }
  statistics->elements += tets.elements;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The same for elements of any kind.
/// @param places where blocks go; null: nothing is added
/// @param counts negative eigenvalues of the elements, appended; may be null
PetscErrorCode assemble_packed(const PackedElements &elements, const double *u,
                               const ElementPlaces *places, double *const *H, double *const *N,
                               bool filtering, TrefoilSplitStatistics *statistics,
                               std::vector<double> *counts) {
  const PetscInt most = chunk_of(elements);
  const auto size = static_cast<std::size_t>(most * elements.entries() * lanes);
  static thread_local std::vector<double> K, negative_parts;
  static thread_local std::vector<int> negative;
  PetscFunctionBeginUser;
  K.resize(size);
  negative_parts.resize(size);
  negative.resize(static_cast<std::size_t>(most * lanes));
  for (PetscInt first = 0; first < elements.packs(); first += most) {
    const PetscInt count = std::min(most, elements.packs() - first);
    elements.hessians(first, count, u, K.data());
    if (H) elements.add_blocks(first, count, K.data(), nullptr, *places, H);
    if (!filtering) continue;
    PetscCall(filter(
        [&] {
          return elements.split(first, count, u, K.data(), negative_parts.data(), negative.data());
        },
        statistics));
    if (N) {
      elements.add_blocks(first, count, negative_parts.data(), negative.data(), *places, N);
    }
    if (counts) counts->insert(counts->end(), negative.begin(), negative.begin() + lanes * count);
  }
  statistics->elements += elements.elements();
  // The copies that fill the last pack have no volume, but in deformation space eigenvalues.
  for (PetscInt e = elements.elements(); filtering && e < lanes * elements.packs(); ++e) {
    const PetscInt first = (elements.packs() - 1) / most * most;
    statistics->indefinite -= negative[static_cast<std::size_t>(e - lanes * first)] > 0;
  }
  if (counts) counts->resize(static_cast<std::size_t>(elements.elements()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode BatchedHessian::set_up(const Discretization &discretization, const Term &term,
                                      Mat H) {
  const auto place = [&](PetscInt row, PetscInt column, BlockPlace *result) {
    return blocks_.place(row, column, &sums_.numbers, result);
  };
  PetscFunctionBeginUser;
  PetscCall(blocks_.begin_placing(discretization, H));
  if (term.packed_elements()) {
    PetscCall(make_element_places(discretization.mesh(), blocks_, &places_));
  } else {
    PetscCall(make_block_sums(*term.packs(), place, &sums_));
  }
  PetscCall(blocks_.end_placing());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BatchedHessian::assemble(const Term &term, const double *u, Mat H, Mat N,
                                        bool filtering, TrefoilSplitStatistics *statistics) const {
  MatrixBlocks::Target H_target, N_target;
  PetscFunctionBeginUser;
  if (H) PetscCall(blocks_.begin(H, &H_target));
  if (N) PetscCall(blocks_.begin(N, &N_target));
  double *const *H_arrays = H ? H_target.arrays : nullptr;
  double *const *N_arrays = N ? N_target.arrays : nullptr;
  if (const PackedElements *elements = term.packed_elements()) {
    PetscCall(assemble_packed(*elements, u, &places_, H_arrays, N_arrays, filtering, statistics,
                              nullptr));
  } else {
    PetscCall(assemble_tets(term, u, sums_, H_arrays, N_arrays, filtering, statistics));
  }
  if (H) PetscCall(blocks_.end(&H_target));
  if (N) PetscCall(blocks_.end(&N_target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BatchedHessian::count_negative(const Term &term, const double *u,
                                              std::vector<double> *counts) {
  TrefoilSplitStatistics ignored{};
  Workspace work;
  PetscFunctionBeginUser;
  counts->clear();
  if (const PackedElements *elements = term.packed_elements()) {
    PetscCall(assemble_packed(*elements, u, nullptr, nullptr, nullptr, true, &ignored, counts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  const Tet4Packs &tets = *term.packs();
  for (PetscInt first = 0; first < tets.packs(); first += chunk) {
    const PetscInt count = std::min(chunk, tets.packs() - first);
    term.reduced_hessians(first, count, u, work.K.data());
    PetscCall(filter(work, count, &ignored));
    counts->insert(counts->end(), work.negative.begin(), work.negative.begin() + lanes * count);
  }
  counts->resize(static_cast<std::size_t>(tets.elements));  // less what fills the last pack
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
