#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace trefoil {

/// What it took a run to come within a relative energy error of its own final energy:
/// (f - f_final) / energy_scale, for errors 1e-1, 1e-2, ... 1e-8. A list of
///   {"relative_error", "iterations", "linear_solves", "seconds"},
/// counted as if the run had ended at the first state that is so close: with the direction that
/// only a stop test needs, with the linear solves and the seconds of the starting guess. In several
/// load steps that state is looked for in the last one, and all the steps before are counted in.
///
/// Only errors that the final energy itself supports: it is off by about its last Newton decrement,
/// and by rounding, and both must be ten times smaller. Empty where the run did not converge.
///
/// @param record the JSON record with `result` and `history` complete
nlohmann::ordered_json error_table(const nlohmann::ordered_json &record);

/// The table in four lines of columns, or nothing where it is empty.
std::string text_of_error_table(const nlohmann::ordered_json &table);

}  // namespace trefoil
