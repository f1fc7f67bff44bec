#include "output/error_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

constexpr double most_exact_error = 1e-8;

/// How far the final energy may be from its minimum's, relative to the energy scale. Infinite where
/// the run tells nothing of it.
double uncertainty(const Json &result) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  for (const char *key : {"energy", "energy_scale", "newton_decrement"}) {
    if (!result.at(key).is_number()) return unknown;
  }
  const double scale = result.at("energy_scale");
  if (!result.at("converged").get<bool>() || !(scale > 0)) return unknown;
  const double rounding =
      std::numeric_limits<double>::epsilon() * std::abs(result.at("energy").get<double>());
  return std::max(result.at("newton_decrement").get<double>(), rounding) / scale;
}

/// Where the last load step's part of the history begins: energies of the steps before belong to
/// other loads, and those of a path that was given up to none that count.
Json::const_iterator last_load_step(const Json &history) {
  if (history.empty()) return history.end();
  const int step = history.back().value("load_step", 1);
  return std::find_if(history.begin(), history.end(), [&](const Json &state) {
    return !state.value("rejected", false) && state.value("load_step", 1) == step;
  });
}

int guess_linear_solves(const Json &result) {
  return result.contains("guess_linear_solves") ? result.at("guess_linear_solves").get<int>() : 0;
}

}  // namespace

Json error_table(const Json &record) {
  constexpr double margin = 10, per_level = 0.1, rounding_of_levels = 1e-6;
  const Json &result = record.at("result"), &history = record.at("history");
  Json table = Json::array();
  const double smallest =
      std::max(margin * uncertainty(result), most_exact_error) * (1 - rounding_of_levels);
  if (!std::isfinite(smallest)) return table;
  const double last = result.at("energy"), scale = result.at("energy_scale");
  const int all_iterations = result.at("iterations");
  const int iterations = result.contains("load_step_iterations")
                             ? result.at("load_step_iterations").back().get<int>()
                             : all_iterations;
  const auto begin = last_load_step(history);
  auto entry = begin;
  for (int digits = 1; std::pow(per_level, digits) >= smallest; ++digits) {
    const double error = std::pow(per_level, digits);
    const auto reached = [&](const Json &state) {
      return state.at("energy").is_number() &&
             state.at("energy").get<double>() - last <= error * scale;
    };
    entry = std::find_if(entry, history.end(), reached);
    if (entry == history.end()) break;
    const int directions = std::min(static_cast<int>(entry - begin) + 1, iterations);
    table.push_back(
        {{"relative_error", std::stod("1e-" + std::to_string(digits))},
         {"iterations", all_iterations - iterations + directions},
         {"linear_solves", guess_linear_solves(result) + entry->at("linear_solves").get<int>()},
         {"seconds", entry->at("seconds")}});
  }
  return table;
}

std::string text_of_error_table(const Json &table) {
  constexpr int label_width = 25;
  if (table.empty()) return "";
  struct Row {
    const char *label, *key, *format;
  };
  std::string text;
  for (const Row &row :
       {Row{"to relative energy error", "relative_error", " %7.0e"},
        Row{"  iterations", "iterations", " %7.0f"},
        Row{"  linear solves", "linear_solves", " %7.0f"}, Row{"  seconds", "seconds", " %7.3g"}}) {
    std::string line = row.label;
    line.resize(label_width, ' ');
    for (const Json &level : table) {
      char number[32];
      std::snprintf(number, sizeof number, row.format, level.at(row.key).get<double>());
      line += number;
    }
    text += line + "\n";
  }
  return text;
}

}  // namespace trefoil
