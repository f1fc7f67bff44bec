#include "solve/saved_numbers.hpp"

#include <cmath>

#include "output/saved_states.hpp"

namespace trefoil {

nlohmann::ordered_json json_of(const TrefoilSearchState &state) {
  const TrefoilIteration &last = state.last;
  nlohmann::ordered_json json{{"trusts_model", state.trusts_model == PETSC_TRUE},
                              {"proxy_scale", state.proxy_scale}};
  if (std::isfinite(state.refused_decrement)) json["refused_decrement"] = state.refused_decrement;
  if (state.has_last) {
    json["last"] = {{"k", last.k},
                    {"energy", last.energy},
                    {"weight", last.weight},
                    {"rho", last.rho},
                    {"step", last.step},
                    {"trials", last.trials},
                    {"decrement", last.decrement},
                    {"indefinite", last.indefinite}};
  }
  return json;
}

TrefoilSearchState search_state_of(const nlohmann::ordered_json &json) {
  TrefoilSearchState state{};
  state.trusts_model = json.at("trusts_model").get<bool>() ? PETSC_TRUE : PETSC_FALSE;
  state.proxy_scale = json.at("proxy_scale");
  state.refused_decrement = json.value("refused_decrement", double{INFINITY});
  state.has_last = json.contains("last") ? PETSC_TRUE : PETSC_FALSE;
  if (state.has_last) {
    const auto &last = json.at("last");
    state.last = {last.at("k"),
                  number_of(last.at("energy")),
                  number_of(last.at("weight")),
                  number_of(last.at("rho")),
                  number_of(last.at("step")),
                  last.at("trials"),
                  number_of(last.at("decrement")),
                  number_of(last.at("indefinite"))};
  }
  return state;
}

nlohmann::ordered_json json_of(const StepSizes::Reached &reached) {
  return {{"time", reached.time},
          {"step", reached.step},
          {"accepted", reached.accepted},
          {"was_halved", reached.was_halved}};
}

StepSizes::Reached steps_reached_of(const nlohmann::ordered_json &json) {
  return {json.at("time"), json.at("step"), json.at("accepted"), json.at("was_halved")};
}

nlohmann::ordered_json json_of(const std::vector<AttemptRecord> &records) {
  auto list = nlohmann::ordered_json::array();
  for (const AttemptRecord &record : records) {
    list.push_back({{"json", record.json},
                    {"load_step", record.load_step},
                    {"is_rejected", record.is_rejected}});
  }
  return list;
}

std::vector<AttemptRecord> records_of(const nlohmann::ordered_json &json) {
  std::vector<AttemptRecord> records;
  for (const auto &record : json) {
    records.push_back({record.at("json"), record.at("load_step"), record.at("is_rejected")});
  }
  return records;
}

nlohmann::ordered_json json_of(const Attempt &attempt) {
  return {{"converged", attempt.converged},
          {"iterations", attempt.iterations},
          {"inverted", attempt.inverted},
          {"reason", attempt.reason},
          {"linear_solver", attempt.linear_solver}};
}

Attempt attempt_of(const nlohmann::ordered_json &json) {
  Attempt attempt;
  attempt.converged = json.at("converged");
  attempt.iterations = json.at("iterations");
  attempt.inverted = json.at("inverted");
  attempt.reason = json.at("reason");
  attempt.linear_solver = json.at("linear_solver");
  return attempt;
}

}  // namespace trefoil
