#pragma once

#include <petscsnes.h>

#include "search/line_search_state.hpp"
#include "search/search_memory.hpp"
#include "search/search_options.hpp"

namespace trefoil {

/// Backtracks from `first_step`, or from the largest that the host allows where that is shorter,
/// until the energy has decreased enough; infinite or undefined energies count as no decrease. A
/// step that only meets lifted boundary values is not judged. Collective.
PetscErrorCode backtrack(const SearchOptions &options, LineSearchState &state, double first_step,
                         PetscInt most_trials, bool *accepted);

/// (f(x + s d) - f(x)) / (s g'd + s^2 d'Hd / 2) at the trial point, with `curvature` d'Hd of the
/// unfiltered Hessian at x; not-a-number where nothing was predicted. Collective.
PetscErrorCode trust_region_ratio(LineSearchState &state, double curvature, double *rho);

/// Goes to the trial point, as the host's post-check sees fit: solution, residual, norms, and what
/// the search remembers of it. Collective.
PetscErrorCode take_step(SNESLineSearch search, LineSearchState &state, SearchMemory &memory);

/// Gives the SNES x back, after trial points that led nowhere.
PetscErrorCode stay(LineSearchState &state);

}  // namespace trefoil
