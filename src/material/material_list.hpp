#pragma once

#include <tuple>
#include <utility>

#include "material/arap.hpp"
#include "material/corotated.hpp"
#include "material/mooney_rivlin.hpp"
#include "material/neo_hookean.hpp"
#include "material/spreading.hpp"
#include "material/st_venant_kirchhoff.hpp"
#include "material/stable_neo_hookean.hpp"
#include "material/symmetric_dirichlet.hpp"

namespace trefoil {

/// The materials that scenes know by name: a new one is one line.
using SceneMaterials = std::tuple<  //
    StableNeoHookean,               //
    NeoHookean,                     //
    MooneyRivlin,                   //
    Arap,                           //
    SymmetricDirichlet,             //
    Corotated,                      //
    StVenantKirchhoff>;

/// What the library compiles for every instruction set: these, and the energies of starting
/// guesses.
using MaterialList = decltype(std::tuple_cat(
    std::declval<SceneMaterials>(), std::declval<std::tuple<HarmonicSpreading, RigidSpreading>>()));

}  // namespace trefoil
