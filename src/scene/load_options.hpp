#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

#include "scene/option_reader.hpp"

namespace trefoil {

/// A dead load on a part of the surface.
struct TractionOptions {
  std::string name;
  std::string where;     ///< expression, non-zero at all three vertices of the facets it takes
  std::string traction;  ///< expression with three values at the centroid: force per rest area
};

/// What pulls at the body. All expressions may depend on t.
struct LoadOptions {
  std::string gravity;  ///< expression with three values: acceleration; empty: none
  std::vector<TractionOptions> tractions;

  [[nodiscard]] bool any() const { return !gravity.empty() || !tractions.empty(); }
};

/// Reads -load_gravity, -loads and, for each name, -load_NAME_where and -load_NAME_traction.
/// Collective.
PetscErrorCode read_loads(MPI_Comm comm, OptionReader &reader, LoadOptions *loads);

}  // namespace trefoil
