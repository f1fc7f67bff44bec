#pragma once

#include <string>

namespace trefoil {

/// The manual page trefoil(1) in man's macros: what the tables of options say, the scene's and the
/// plugin's. What --help man prints; the build writes it to trefoil.1.
std::string manual_page();

}  // namespace trefoil
