#pragma once

#include <string>

namespace trefoil {

/// That linear elements lock in a body, and how much too stiff they were measured to be in one
/// whose Poisson's ratio is near.
/// @param dimension 2 or 3
/// @param poisson the body's, above 0.4545
/// @param has_contact which is for linear elements alone
std::string warn_of_locking(int dimension, double poisson, bool has_contact);

}  // namespace trefoil
