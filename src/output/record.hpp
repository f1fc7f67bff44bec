#pragma once

#include <nlohmann/json.hpp>

#include "output/run_report.hpp"

namespace trefoil {

/// The JSON record of a whole run: the plugin's, completed. No object where the plugin left none.
nlohmann::ordered_json make_record(const RunReport &report);

/// The closing words of a run, for the screen: converged or why not, iterations, energies, what the
/// body does, time by phase.
std::string summary_of(const nlohmann::ordered_json &record);

}  // namespace trefoil
