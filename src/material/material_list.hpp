#pragma once

#include <tuple>

#include "material/spreading.hpp"
#include "material/stable_neo_hookean.hpp"

namespace trefoil {

/// The materials that the library compiles for every instruction set: a new one is one line.
using MaterialList = std::tuple<StableNeoHookean, HarmonicSpreading, RigidSpreading>;

}  // namespace trefoil
