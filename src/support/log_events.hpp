#pragma once

#include <petsclog.h>

namespace trefoil {

/// Events of -log_view, registered by TrefoilInitializePackage(): eigenvalue filtering, the
/// Jacobian's assembly (filtering included), the line search, the search for pairs in contact.
extern PetscLogEvent event_filter, event_assembly, event_search, event_pairs;

}  // namespace trefoil
