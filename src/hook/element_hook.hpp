#pragma once

#include <petscmat.h>

#include <string>
#include <vector>

#include "filter/filter.hpp"
#include "hook/insertion_counts.hpp"
#include "hook/seen_sum.hpp"
#include "hook/sign_pattern.hpp"

namespace trefoil {

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

  // What a host may do to the whole Mat when its elements are in; each is called before it is done,
  // is collective, and carries it to N.

  /// The Mat is zeroed, and begins anew.
  PetscErrorCode restart();
  /// It is multiplied by a number.
  PetscErrorCode scale(Mat matrix, double factor);
  /// Its rows and columns are multiplied by vectors, of which one may be null; take_as_seen() has
  /// to follow when that is done.
  PetscErrorCode scale_diagonally(Mat matrix, Vec left, Vec right);
  /// A vector, or where that is null a number, is added to its diagonal.
  PetscErrorCode add_to_diagonal(Mat matrix, Vec diagonal, double constant);
  /// The Mat as it is now is what was seen.
  PetscErrorCode take_as_seen(Mat matrix);
  /// Rows are zeroed.
  void note_zeroed(PetscInt count, const PetscInt *rows, bool columns_too);

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
  PetscErrorCode take_single(PetscInt row, PetscInt column, PetscScalar value);
  PetscErrorCode split_all(PetscInt n, const PetscInt *index, const PetscScalar *values);
  PetscErrorCode split_fields(PetscInt n, const PetscInt *index, const PetscScalar *values);
  PetscErrorCode keep(PetscInt n, const PetscInt *index, const double *N);
  PetscErrorCode flush_stash(Mat negative);
  PetscErrorCode assemble_negative(Mat matrix, bool needed);
  PetscErrorCode compare(Mat matrix);
  PetscErrorCode find_saddle_pattern(Mat matrix);
  PetscErrorCode zero_rows_of(Mat negative);
  PetscErrorCode duplicate_pattern(Mat matrix, Mat *negative);
  PetscErrorCode follow_pattern(Mat matrix, Mat *negative);
  PetscErrorCode has_pattern(Mat matrix, Mat negative, bool *same);
  void forget();
  void forget_stash();

  /// Rows that the host zeroes during its callback.
  struct ZeroedRows {
    bool columns_too;
    std::vector<PetscInt> rows;
  };

  bool active_ = false, always_ = false;
  Mat negative_ = nullptr;  ///< while active; the caller's, also where it is made here
  const std::vector<char> *in_field_ = nullptr;
  PetscObjectId duplicate_ = 0;  ///< the N that was duplicated, and both patterns at that time
  PetscObjectState pattern_of_matrix_ = 0, pattern_of_negative_ = 0;
  EigenvalueFloor floor_;
  InsertionCounts counts_;
  PetscInt64 rising_ = 0;  ///< elements with a positive eigenvalue
  SeenSum seen_;
  SignPattern pattern_;
  bool pattern_is_known_ = false, all_are_of_saddle_ = false;
  double filter_seconds_ = 0;
  std::vector<PetscInt> stashed_sizes_, stashed_indices_;
  std::vector<double> stashed_values_;
  std::vector<ZeroedRows> zeroed_;
  std::vector<double> block_, N_;                    // work
  std::vector<PetscInt> index_, columns_, members_;  // work
};

}  // namespace trefoil
