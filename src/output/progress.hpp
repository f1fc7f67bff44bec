#pragma once

#include <petscsys.h>

#include <string>

namespace trefoil {

/// Lines about work that takes long, on stderr: what is being done, the seconds since the run began
/// and the memory of the largest rank. None before the first interval is over, so that short runs
/// say nothing; stdout is the same however long a run takes.
class Progress {
 public:
  /// Without this there are no lines. Collective.
  /// @param seconds from one line to the next; 0: none
  PetscErrorCode begin(MPI_Comm comm, double seconds);

  [[nodiscard]] bool is_on() const { return seconds_ > 0; }
  /// A moment at which a line is shown, if one is due. Collective.
  PetscErrorCode pass(const std::string &work);

  /// The same without a word between ranks, for moments that come often: the memory is that of the
  /// last pass(). Only the first rank has lines that are due.
  [[nodiscard]] bool is_due() const;
  void show(const std::string &work);

 private:
  MPI_Comm comm_ = MPI_COMM_NULL;
  bool is_first_rank_ = false;
  double seconds_ = 0, begin_ = 0, last_ = 0;
  double bytes_ = 0;  ///< of the largest rank
};

}  // namespace trefoil
