#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace trefoil {

/// Whether what is prescribed meets an obstacle, or something else that is prescribed, on its own
/// way between two times, wherever free bodies are: no shorter step then leads to the end of it.
/// The way is followed in parts that become shorter towards what is met. Collective.
/// @param u local displacements at `from`
/// @param meeting one sentence that names the two, the time and the place, or nothing
PetscErrorCode find_meeting_of_prescribed(Scene &scene, const std::vector<double> &u, double from,
                                          double to, std::string *meeting);

}  // namespace trefoil
