#pragma once

#include <petscsnes.h>

#include <string>
#include <vector>

#include "hook/element_hook.hpp"
#include "hook/filtered_jacobian.hpp"

namespace trefoil {

/// The Jacobian callback of a host that knows nothing of us, run with its Mat watched.
class HostJacobian {
 public:
  using Function = PetscErrorCode (*)(SNES, Vec, Mat, Mat, void *);

  HostJacobian() = default;
  HostJacobian(const HostJacobian &) = delete;
  HostJacobian &operator=(const HostJacobian &) = delete;
  ~HostJacobian();

  /// Takes over the callback that the SNES has now, which ours is about to replace, and keeps what
  /// owns its context from being destroyed with it.
  PetscErrorCode take_over(SNES snes, Function function, void *context);

  /// The host's callback as it is.
  PetscErrorCode compute(SNES snes, Vec x, Mat J, Mat H) const {
    return function_(snes, x, J, H, context_);
  }
  /// Runs it and collects N from the element blocks that it adds to H. Collective.
  /// @param fields names of the fields to filter, see -snes_trefoil_fields; empty: all
  /// @param strict what cannot be filtered is an error on all ranks, else it is counted
  PetscErrorCode compute_watched(SNES snes, Vec x, Mat J, Mat H, const std::string &fields,
                                 bool strict, const EigenvalueFloor &floor,
                                 FilteredJacobian &jacobian, InsertionCounts *counts,
                                 double *filter_seconds);

  /// Takes the hook off the Mat, whose N and fields are no longer known.
  PetscErrorCode release(FilteredJacobian &jacobian);

 private:
  PetscErrorCode watch(SNES snes, Vec x, Mat H, const std::string &fields,
                       FilteredJacobian &jacobian, ElementHook **hook);

  Function function_ = nullptr;
  void *context_ = nullptr;
  PetscObject context_keeper_ = nullptr;
  Mat watched_ = nullptr;
  std::vector<char> in_field_;  ///< unknowns to filter; empty: all
};

}  // namespace trefoil
