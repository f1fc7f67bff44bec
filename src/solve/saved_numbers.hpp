#pragma once

#include <nlohmann/json.hpp>

#include "solve/run_record.hpp"
#include "solve/scene_solver.hpp"
#include "solve/step_sizes.hpp"
#include "trefoil.h"

namespace trefoil {

/// The numbers of what a search carries from one iteration to the next.
nlohmann::ordered_json json_of(const TrefoilSearchState &state);
/// @param json of json_of(); what is missing there is an exception of nlohmann's
TrefoilSearchState search_state_of(const nlohmann::ordered_json &json);

/// How far a way has led.
nlohmann::ordered_json json_of(const StepSizes::Reached &reached);
StepSizes::Reached steps_reached_of(const nlohmann::ordered_json &json);

/// Solves that are recorded one by one.
nlohmann::ordered_json json_of(const std::vector<AttemptRecord> &records);
std::vector<AttemptRecord> records_of(const nlohmann::ordered_json &json);

/// How a solve went, without its record.
nlohmann::ordered_json json_of(const Attempt &attempt);
Attempt attempt_of(const nlohmann::ordered_json &json);

}  // namespace trefoil
