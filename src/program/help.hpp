#pragma once

#include <string>

namespace trefoil {

/// What --help prints: one screen, the options that most scenes need.
std::string short_help();
/// All options of a scene by groups, with defaults and units: the first part of --help all.
std::string scene_help();
/// What --version prints: Trefoil, PETSc, ranks, and the instruction set of the kernels.
std::string version_text(int ranks);

}  // namespace trefoil
