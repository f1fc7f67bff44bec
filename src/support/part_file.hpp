#pragma once

#include <string>

namespace trefoil {

/// Creates an empty file beside `path` under a name that no other run has: path.PID.XXXXXX.part.
/// @param problem what went wrong, empty where nothing did
/// @return its name
std::string make_part(const std::string &path, std::string *problem);

/// Removes such parts of `path`, and of what is named after it (bar.h5 and bar_0007.vtu with
/// bar.xdmf), that processes have left which this machine no longer runs.
void remove_stale_parts(const std::string &path);

}  // namespace trefoil
