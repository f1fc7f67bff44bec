#pragma once

#include <petscmat.h>

#include <string>
#include <vector>

#include "filter/filter.hpp"

namespace trefoil {

/// What went into a hooked Mat during one Jacobian callback. Counts of this rank, then of all.
struct InsertionCounts {
  PetscInt64 elements = 0;      ///< element blocks: added, square, the same indices on both sides
  PetscInt64 indefinite = 0;    ///< of these, with a negative eigenvalue
  PetscInt64 rectangular = 0;   ///< added blocks with different numbers of rows and columns
  PetscInt64 partial = 0;       ///< of the rectangular ones, with rows that are among the columns
  PetscInt64 nonsymmetric = 0;  ///< element blocks that are not symmetric
  PetscInt64 saddle = 0;        ///< element blocks with a zero on the diagonal of a non-zero row
  PetscInt64 not_finite = 0;    ///< element blocks with NaN or Inf
  PetscInt64 too_large = 0;     ///< element blocks larger than the filter takes

  [[nodiscard]] PetscInt64 unfiltered() const {
    return rectangular + nonsymmetric + saddle + not_finite + too_large;
  }
  InsertionCounts &operator+=(const InsertionCounts &more);
};

/// Records what a host adds to its Mat: every element block that is added while the hook is active
/// is split, H_e goes on unchanged, and N_e is added to a second Mat of the same pattern. Works on
/// the insertion operations that the Mat's type has; inactive it records nothing.
class ElementHook {
 public:
  /// Puts the hook on a Mat, or returns the one that is there. From PETSc 3.19 on an AIJ exchanges
  /// its operations at its first assembly, so this is called again before every Jacobian.
  static PetscErrorCode attach(Mat matrix, ElementHook **hook);
  /// Takes it off; harmless where there is none.
  static PetscErrorCode detach(Mat matrix);
  /// The hook on a Mat, or null.
  static ElementHook *find(Mat matrix);

  /// Begins to collect; `negative` (may be null: then N_e is stashed) is zeroed.
  /// @param in_field marks the unknowns to filter, by global number; null: all
  PetscErrorCode begin(Mat negative, const std::vector<char> *in_field);
  /// Keeps the filtered eigenvalues of blocks above a floor, until told otherwise.
  void set_floor(const EigenvalueFloor &floor) { floor_ = floor; }
  /// Ends it. If any rank has met an indefinite element, *negative is N, made when needed and
  /// assembled, with the rows zeroed that the host has zeroed meanwhile, and with the nonzero
  /// pattern of `matrix`. Collective.
  PetscErrorCode end(Mat matrix, Mat *negative, InsertionCounts *total, double *filter_seconds);

  /// The host has zeroed its Mat and begins anew. Collective.
  PetscErrorCode restart();

  /// Splits one element block and keeps N_e. Not collective.
  PetscErrorCode take_element(PetscInt n, const PetscInt *index, const PetscScalar *values);

  [[nodiscard]] bool active() const { return active_; }
  /// Whether keep_active() was called.
  [[nodiscard]] bool always_active() const { return always_; }
  /// Collects outside Jacobian callbacks, too: for hosts that assemble elsewhere.
  void keep_active() { always_ = active_ = true; }

  /// Suspends recording, or takes it up again.
  void pause(bool paused) { active_ = !paused; }

  struct Operations;  ///< the Mat's own insertion operations

 private:
  friend struct Operations;
  PetscErrorCode watch(PetscInt m, const PetscInt *rows, PetscInt n, const PetscInt *columns,
                       const PetscScalar *values, InsertMode mode, PetscInt block_size);
  PetscErrorCode split_all(PetscInt n, const PetscInt *index, const PetscScalar *values);
  PetscErrorCode split_fields(PetscInt n, const PetscInt *index, const PetscScalar *values);
  PetscErrorCode keep(PetscInt n, const PetscInt *index, const double *N);
  PetscErrorCode flush_stash(Mat negative);
  PetscErrorCode zero_rows_of(Mat negative);
  PetscErrorCode duplicate_pattern(Mat matrix, Mat *negative);
  PetscErrorCode follow_pattern(Mat matrix, Mat *negative);
  PetscErrorCode has_pattern(Mat matrix, Mat negative, bool *same);
  void forget();

  /// Rows that the host zeroes during its callback.
  struct ZeroedRows {
    bool columns_too;
    std::vector<PetscInt> rows;
  };

  bool active_ = false, always_ = false;
  Mat negative_ = nullptr;  ///< borrowed while active
  const std::vector<char> *in_field_ = nullptr;
  PetscObjectId duplicate_ = 0;  ///< the N that was duplicated, and both patterns at that time
  PetscObjectState pattern_of_matrix_ = 0, pattern_of_negative_ = 0;
  EigenvalueFloor floor_;
  InsertionCounts counts_;
  double filter_seconds_ = 0;
  std::vector<PetscInt> stashed_sizes_, stashed_indices_;
  std::vector<double> stashed_values_;
  std::vector<ZeroedRows> zeroed_;
  std::vector<double> block_, N_;          // work
  std::vector<PetscInt> index_, members_;  // work
};

}  // namespace trefoil
