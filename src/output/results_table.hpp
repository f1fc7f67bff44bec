#pragma once

#include <petscsys.h>

#include <string>

#include "output/run_report.hpp"

namespace trefoil {

/// The results as comma-separated values: a line of names, then one for each state but loose ones.
/// Names come from the report's constraints, loads, and first state.
std::string results_table(const RunReport &report);

/// That table in a file, which is whole after every state: a run that is killed leaves what it had.
/// A device or a pipe gets it at the end.
class ResultsFile {
 public:
  /// @param path empty: none is written
  ResultsFile(MPI_Comm comm, const std::string &path) : comm_(comm), path_(path) {}

  /// Writes the report's last state, at first with those before it in place of what stood in the
  /// file. Collective; PETSC_ERR_FILE_OPEN with a sentence where it cannot be written.
  PetscErrorCode add(const RunReport &report);
  /// Writes what is not written yet: a table without states, or that of a pipe. Collective.
  PetscErrorCode end(const RunReport &report);

 private:
  MPI_Comm comm_;
  std::string path_;
  bool is_begun_ = false;
};

}  // namespace trefoil
