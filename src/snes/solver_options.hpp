#pragma once

#include <petscsnes.h>

#include <string>
#include <vector>

#include "rule/rule.hpp"
#include "search/search_options.hpp"
#include "trefoil.h"

namespace trefoil {

/// The plugin's options, see options.cpp for their names and help texts.
struct SolverOptions {
  std::string filter = "newton_first";
  RuleParameters rule;
  bool weight_set = false;  ///< by the user, for filter `constant`
  double floor = -1;        ///< share of an element's largest |eigenvalue|; < 0: the rule's
  TrefoilSpace space = TREFOIL_SPACE_ELEMENT;
  std::string fields;  ///< names of the fields to filter; empty: all
  bool strict = true;  ///< a Jacobian that cannot be filtered is an error
  SearchOptions search;
  StopOptions stop;
  bool monitor = false;
  std::string record_file;  ///< empty: no record
};

/// Reads the options of a SNES; a misspelt name, or a value that makes no sense, is an error.
/// Collective.
/// @param[out] idle a sentence for each option that is given and has no effect beside the others
PetscErrorCode read_options(SNES snes, SolverOptions *options, std::vector<std::string> *idle);

/// Refuses values that make no sense, whoever set them.
PetscErrorCode check_options(SNES snes, SolverOptions &options);

/// Prints every option with its value.
PetscErrorCode view_options(SolverOptions options, PetscViewer viewer);

/// The options as PETSc's manual pages list them, one a line: name, default, help text.
std::string manual_of_options();

}  // namespace trefoil
