#pragma once

#include <string>
#include <vector>

#include "input/option_table.hpp"
#include "mesh/bodies.hpp"

namespace trefoil {

/// One of several bodies as the user describes it.
struct BodyOptions {
  std::string name;
  std::string file = {}, generate = {};  ///< one of them
  PetscInt resolution = 0;
  double scale = 1;
  std::string rotate = {};     ///< degrees about z, or an axis and degrees
  std::string translate = {};  ///< two or three numbers
};

std::vector<OptionRow> body_rows(BodyOptions &body);

/// Reads the bodies that are named by -bodies, or those of the files in -mesh_files, which are
/// called by their files' names without ending. Collective; what makes no body is an error with one
/// sentence on all ranks.
PetscErrorCode read_bodies(MPI_Comm comm, OptionReader &reader,
                           const std::vector<std::string> &files, std::vector<BodySource> *bodies);

}  // namespace trefoil
