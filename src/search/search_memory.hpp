#pragma once

#include <vector>

#include "rule/iteration_record.hpp"
#include "search/search_options.hpp"
#include "search/work_vectors.hpp"

namespace trefoil {

/// What the search carries from one iteration of a solve to the next.
struct SearchMemory {
  WorkVectors vectors;
  bool keeps_steps = false;          ///< for the planes of search `subspace`
  bool previous_step_known = false;  ///< in this solve
  /// Whether the quadratic model has been seen to predict well. From a start with crushed elements
  /// the minimum in a plane keeps some of them so, in another minimum of the energy than the best
  /// (measured on the paper's scenes); there backtracking goes first, until |rho - 1| is small.
  bool trusts_model = false;
  /// Length of the directions of a proxy, by the last step along one.
  double proxy_scale = 1;
  /// Dirichlet values of a host may not be met yet: true at a solve's start, false once they are.
  bool boundary_values_open = false;
  std::vector<char> held_rows;  ///< of this rank, by such values; empty: none, or not known

  /// @param may_lift the host may enforce Dirichlet values by the first step
  PetscErrorCode begin_solve(const SearchOptions &options, bool may_lift);
  /// Takes in how well a step was predicted.
  void learn(const IterationRecord &iteration, double rho_tolerance);
  /// Whether steps start from the energy's minimum in the plane of direction and previous step.
  [[nodiscard]] bool uses_planes(const SearchOptions &options) const {
    return options.kind == TREFOIL_SEARCH_SUBSPACE && trusts_model;
  }
};

}  // namespace trefoil
