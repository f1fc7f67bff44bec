#pragma once

#include <string>

#include "input/option_table.hpp"

namespace trefoil {

/// What --help prints: one screen, the options that most scenes need.
std::string short_help();
/// All options of a scene by groups, with defaults and units: the first part of --help all.
std::string scene_help();
/// The same for programs: a line an option, `group`, `name`, `what it is`, `unit` and `default`
/// with tabs between them. What --help keys prints.
std::string scene_keys();
/// One option with all that its row says: what it is, choices, unit and default.
std::string help_of(const OptionRow &row);
/// What --version prints: Trefoil, PETSc, ranks, and the instruction set of the kernels.
std::string version_text(int ranks);

}  // namespace trefoil
