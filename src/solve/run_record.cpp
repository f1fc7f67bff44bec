#include "solve/run_record.hpp"

namespace trefoil {

void RunRecord::add(const std::string &text, int number, bool is_rejected) {
  Json record = Json::parse(text, nullptr, false);
  if (!record.is_object()) return;
  Json &result = record["result"];
  const int solves_before = solves_ == 0 ? 0 : last_["result"]["linear_solves"].get<int>();
  const bool was_softer = !history_.empty() && history_.back()[step_] == 0;  // see soften_start()
  for (Json entry : record["history"]) {
    entry["k"] = history_.size();
    entry["linear_solves"] = solves_before + entry["linear_solves"].get<int>();
    entry[step_] = number;
    if (is_rejected) entry["rejected"] = true;
    history_.push_back(std::move(entry));
  }
  record.erase("history");
  if (!is_rejected && number == last_number_) {  // a step in two solves
    iterations_.back() = iterations_.back().get<int>() + result["iterations"].get<int>();
  } else if (!is_rejected) {
    iterations_.push_back(result["iterations"]);
    last_number_ = number;
  }
  if (solves_ > 0) {
    for (const char *count : {"saddles_left", "verification_solves", "iterations", "linear_solves",
                              "factorisations", "line_search_trials"}) {
      result[count] = result[count].get<int>() + last_["result"][count].get<int>();
    }
    if (!was_softer) result["energy_start"] = last_["result"]["energy_start"];
    for (auto &[phase, seconds] : record["time"].items()) {
      seconds = seconds.get<double>() + last_["time"][phase].get<double>();
    }
  }
  only_ = solves_ == 0 ? text : "";
  ++solves_;
  any_rejected_ = any_rejected_ || is_rejected;
  last_ = std::move(record);
}

void RunRecord::add(const std::vector<AttemptRecord> &records, bool count) {
  for (const AttemptRecord &record : records) {
    add(record.json, record.load_step, record.is_rejected || !count);
  }
}

RunRecord::Json RunRecord::save() const {
  return {{"only", only_},
          {"solves", solves_},
          {"last_number", last_number_},
          {"any_rejected", any_rejected_},
          {"last", last_},
          {"history", history_},
          {"iterations", iterations_}};
}

void RunRecord::load(const Json &json) {
  only_ = json.at("only");
  solves_ = json.at("solves");
  last_number_ = json.at("last_number");
  any_rejected_ = json.at("any_rejected");
  last_ = json.at("last");
  history_ = json.at("history");
  iterations_ = json.at("iterations");
}

std::string RunRecord::text() const {
  if (solves_ == 0) return "";
  if (solves_ == 1 && !any_rejected_) return only_;
  Json record = last_;
  record["result"][step_ + "_iterations"] = iterations_;
  record["history"] = history_;
  return record.dump(1);
}

}  // namespace trefoil
