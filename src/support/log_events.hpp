#pragma once

#include <petsclog.h>

namespace trefoil {

/// Events of -log_view, registered by TrefoilInitializePackage(): eigenvalue filtering, the
/// Jacobian's assembly (filtering included), the line search.
extern PetscLogEvent event_filter, event_assembly, event_search;

}  // namespace trefoil
