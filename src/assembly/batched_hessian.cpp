#include "assembly/batched_hessian.hpp"

#include <petsctime.h>

#include <algorithm>

#include "filter/reduced_filter.hpp"
#include "petsc_compatibility.hpp"
#include "snes/log_events.hpp"

namespace trefoil {
namespace {

/// Packs worked on at a time: their matrices stay in the second-level cache, and the filter has
/// enough of them to sort by the number of negative eigenvalues.
constexpr PetscInt chunk = 64;
static_assert(chunk % BlockSums::stretch == 0);

/// Memory of one chunk.
struct Workspace {
  std::vector<double> K = std::vector<double>(chunk * reduced_entries * lanes);
  std::vector<double> N = std::vector<double>(chunk * reduced_entries * lanes);
  std::vector<int> negative = std::vector<int>(chunk * lanes);
};

/// Splits a chunk's matrices and counts the indefinite ones, copies that fill the last pack aside.
PetscErrorCode filter(Workspace &work, PetscInt packs, TrefoilSplitStatistics *statistics) {
  PetscLogDouble begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscLogEventBegin(event_filter, nullptr, nullptr, nullptr, nullptr));
  PetscCall(PetscTime(&begin));
  const SplitResult result =
      split_reduced(static_cast<int>(packs), work.K.data(), work.N.data(), work.negative.data());
  PetscCall(PetscTime(&end));
  PetscCall(PetscLogEventEnd(event_filter, nullptr, nullptr, nullptr, nullptr));
  PetscCheck(result.status == SplitStatus::ok || result.status == SplitStatus::not_finite,
             PETSC_COMM_SELF, PETSC_ERR_LIB, "no eigenvalues of an element Hessian were found");
  statistics->filter_seconds += end - begin;
  statistics->indefinite += result.indefinite;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode BatchedHessian::assemble(const Term &term, const double *u, Mat H, Mat N,
                                        bool filtering, TrefoilSplitStatistics *statistics) const {
  const Tet4Packs &tets = *term.packs();
  static const AddBlocks add_blocks = add_blocks_kernel();
  static thread_local Workspace work;
  DirectAssembly::Target H_target, N_target;
  PetscFunctionBeginUser;
  if (H) PetscCall(direct_.begin(H, &H_target));
  if (N) PetscCall(direct_.begin(N, &N_target));
  for (PetscInt first = 0; first < tets.packs(); first += chunk) {
    const PetscInt count = std::min(chunk, tets.packs() - first);
    term.reduced_hessians(first, count, u, work.K.data());
    if (H) {
      add_blocks(direct_.sums(), first, count, work.K.data(), nullptr, H_target.arrays);
    }
    if (!filtering) continue;
    PetscCall(filter(work, count, statistics));
    if (N) {
      add_blocks(direct_.sums(), first, count, work.N.data(), work.negative.data(),
                 N_target.arrays);
    }
  }
  statistics->elements += tets.elements;
  if (H) PetscCall(direct_.end(&H_target));
  if (N) PetscCall(direct_.end(&N_target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode BatchedHessian::count_negative(const Term &term, const double *u,
                                              std::vector<double> *counts) {
  const Tet4Packs &tets = *term.packs();
  TrefoilSplitStatistics ignored{};
  Workspace work;
  PetscFunctionBeginUser;
  counts->clear();
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
