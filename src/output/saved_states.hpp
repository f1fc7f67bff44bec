#pragma once

#include <nlohmann/json.hpp>

#include "output/run_report.hpp"

namespace trefoil {

/// States as numbers that a run which goes on has again, digit by digit.
nlohmann::ordered_json save(const StateReport &state);
/// @param json of save(); what is missing there is an exception of nlohmann's
StateReport load_state(const nlohmann::ordered_json &json);

/// A number of JSON, which has no infinity and no NaN: null.
double number_of(const nlohmann::ordered_json &json);

}  // namespace trefoil
