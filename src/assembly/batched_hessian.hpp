#pragma once

#include "assembly/direct_assembly.hpp"
#include "assembly/element_assembly.hpp"
#include "term/term.hpp"
#include "trefoil.h"

namespace trefoil {

/// H and N of a term whose elements come in packs: reduced Hessians in batches, filtered in
/// batches, added straight into the matrices. The plain path next to it, HessianAssembler, tests
/// it.
class BatchedHessian {
 public:
  /// Prepares for matrices with the pattern of H. Collective.
  PetscErrorCode set_up(const Discretization &discretization, const Term &term, Mat H) {
    if (term.packed_elements()) return elements_.set_up(discretization, H);
    return direct_.set_up(discretization, *term.packs(), H);
  }
  [[nodiscard]] bool ready() const { return direct_.ready() || elements_.ready(); }
  [[nodiscard]] double bytes() const { return direct_.bytes() + elements_.bytes(); }

  /// Sets H (may be null: left alone) and N (may be null: not wanted) at the local displacements u.
  /// @param filtering false: H only, nothing is split
  /// @param statistics counts and seconds are added
  /// Collective.
  PetscErrorCode assemble(const Term &term, const double *u, Mat H, Mat N, bool filtering,
                          TrefoilSplitStatistics *statistics) const;

  /// Number of negative eigenvalues of each element's Hessian at u, in the order of the cells.
  static PetscErrorCode count_negative(const Term &term, const double *u,
                                       std::vector<double> *counts);

 private:
  PetscErrorCode assemble_elements(const PackedElements &elements, const double *u, Mat H, Mat N,
                                   bool filtering, TrefoilSplitStatistics *statistics) const;

  DirectAssembly direct_;     ///< of Tet4Packs
  ElementAssembly elements_;  ///< of PackedElements
};

}  // namespace trefoil
