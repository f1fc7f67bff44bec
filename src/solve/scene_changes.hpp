#pragma once

#include <map>
#include <string>

namespace trefoil {

/// Of options that were given, by name, those that the energy or its constraints are made of.
std::map<std::string, std::string> options_of_energy(
    const std::map<std::string, std::string> &given);

/// Likewise those that say how its minimum is walked to.
std::map<std::string, std::string> options_of_way(const std::map<std::string, std::string> &given);

/// In which options two scenes differ, for a sentence: "-material_young 1e6 there, 2e6 here";
/// empty: in none. Texts are compared, not what they mean.
std::string differences(const std::map<std::string, std::string> &there,
                        const std::map<std::string, std::string> &here);

}  // namespace trefoil
