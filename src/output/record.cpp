#include "output/record.hpp"

#include <algorithm>
#include <cmath>

#include "output/error_table.hpp"

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no NaN and no infinity; null says "not finite".
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json place(const Extreme &extreme) {
  return {{"value", number(extreme.value)}, {"at", extreme.at}};
}

Json mesh_json(const MeshReport &mesh) {
  return {{"vertices", mesh.vertices},
          {"nodes", mesh.nodes},
          {"elements", mesh.elements},
          {"parts", mesh.parts},
          {"element", mesh.element},
          {"element_pressure", mesh.element_pressure},
          {"dofs", mesh.dofs},
          {"free_dofs", mesh.free_dofs},
          {"edge_cut", mesh.edge_cut},
          {"imbalance", mesh.imbalance},
          {"inverted_at_start", mesh.inverted_at_start}};
}

Json constraints_json(const RunReport &report) {
  Json list = Json::array();
  for (const ConstraintReport &constraint : report.constraints) {
    list.push_back({{"name", constraint.name},
                    {"vertices", constraint.vertices},
                    {"area", constraint.area},
                    {"reaction", constraint.reaction.force},
                    {"moment", constraint.reaction.moment}});
  }
  return list;
}

Json loads_json(const RunReport &report) {
  Json list = Json::array();
  for (const LoadReport &load : report.loads) {
    list.push_back({{"name", load.name},
                    {"facets", load.facets},
                    {"area", load.area},
                    {"force", load.resultant.force},
                    {"moment", load.resultant.moment}});
  }
  return list;
}

Json regions_json(const RunReport &report) {
  Json list = Json::array();
  for (const RegionReport &region : report.regions) {
    list.push_back({{"name", region.name},
                    {"cells", region.cells},
                    {"volume", region.volume},
                    {"mass", region.mass}});
  }
  return list;
}

void add_contact(const ContactState &contact, Json &json) {
  json["contact_energy"] = number(contact.energy);
  json["min_gap"] = number(contact.least_gap);
  json["contact_pairs"] = contact.pairs;
  json["contact_distance"] = contact.distance;
  json["contact_stiffening"] = contact.stiffening;
  json["friction_iterations"] = contact.friction_iterations;
  if (contact.friction_force > 0) {
    json["friction_change"] = number(contact.friction_change / contact.friction_force);
  }
  if (contact.obstacles.empty()) return;
  Json forces = Json::object();
  for (const ObstacleReport &obstacle : contact.obstacles) forces[obstacle.name] = obstacle.force;
  json["contact_forces"] = forces;
}

Json state_json(const RunReport &report, const StateReport &state) {
  Json reactions = Json::object(), loads = Json::object(), probes = Json::object();
  for (std::size_t k = 0; k < state.reactions.size(); ++k) {
    reactions[report.constraints[k].name] = state.reactions[k].force;
  }
  for (std::size_t k = 0; k < state.loads.size(); ++k) {
    loads[report.loads[k].name] = state.loads[k].force;
  }
  for (const ProbeReport &probe : state.probes) probes[probe.name] = probe.displacement;
  Json json{{"t", state.t},
            {"energy", number(state.energy)},
            {"strain_energy", number(state.strain_energy)},
            {"load_work", number(state.load_work)},
            {"iterations", state.iterations},
            {"reaction", reactions},
            {"load", loads},
            {"largest_displacement", place(state.largest_displacement)},
            {"least_det_F", place(state.least_determinant)},
            {"largest_von_mises", place(state.largest_von_mises)},
            {"volume", number(state.volume)}};
  if (state.is_loose) json["loose"] = true;
  if (state.is_rejected) json["rejected"] = true;
  if (!state.probes.empty()) json["probes"] = probes;
  if (state.motion) {
    json["dt"] = state.motion->step;
    json["kinetic_energy"] = number(state.motion->kinetic_energy);
    json["momentum"] = state.motion->momentum;
    json["angular_momentum"] = state.motion->angular_momentum;
  }
  if (state.contact) add_contact(*state.contact, json);
  return json;
}

/// What the plugin counted as `other` is its part of the program's remainder. Waiting, which is in
/// the maxima of several phases, must not make them more than the whole.
void complete_times(Json &time, const ProgramTimes &times) {
  time["read"] = times.read;
  time["setup"] = times.setup;
  time["guess"] = times.guess;
  time["output"] = times.output;
  const char *phases[] = {"read",   "setup",        "guess",       "assembly",
                          "filter", "linear_solve", "line_search", "output"};
  double named = 0;
  for (const char *phase : phases) named += time[phase].get<double>();
  const double share = named > times.total ? times.total / named : 1;
  for (const char *phase : phases) time[phase] = share * time[phase].get<double>();
  time["total"] = times.total;
  time["other"] = std::max(times.total - share * named, 0.0);  // named may round up
}

}  // namespace

Json make_record(const RunReport &report) {
  Json record = Json::parse(report.plugin_record, nullptr, false);
  if (!record.is_object()) return record;
  if (!report.restarted_from.empty()) record["restarted_from"] = report.restarted_from;
  record["mesh"] = mesh_json(report.mesh);
  record["constraints"] = constraints_json(report);
  record["loads"] = loads_json(report);
  record["regions"] = regions_json(report);
  record["steps"] = Json::array();
  for (const StateReport &state : report.states) {
    record["steps"].push_back(state_json(report, state));
  }
  record["solver"]["linear"] = report.linear_solver;
  record["solver"]["linear_reason"] = report.linear_solver_reason;
  Json &result = record["result"];
  const StateReport &end = report.end;
  if (!report.failure.empty()) {
    result["converged"] = false;
    result["reason"] = report.failure;
    result["energy"] = number(end.energy);
    result["t"] = end.t;
  }
  if (end.motion) {
    result["t"] = end.t;
    result["energy"] = number(end.energy);  // without that of the step's inertia
    result["kinetic_energy"] = number(end.motion->kinetic_energy);
    result["momentum"] = end.motion->momentum;
    result["angular_momentum"] = end.motion->angular_momentum;
  }
  result["strain_energy"] = number(end.strain_energy);
  result["load_work"] = number(end.load_work);
  result["largest_displacement"] = place(end.largest_displacement);
  result["least_det_F"] = place(end.least_determinant);
  result["largest_von_mises"] = place(end.largest_von_mises);
  result["volume"] = number(end.volume);
  for (const ProbeReport &probe : end.probes) result["probes"][probe.name] = probe.displacement;
  if (end.contact) {
    const auto &history = record["history"];
    add_contact(*end.contact, result);
    result["truncated"] = std::count_if(history.begin(), history.end(), [](const Json &entry) {
      return entry.value("truncated", false);
    });
  }
  result["warnings"] = report.warnings;
  result["energy_rest"] = report.energy_rest;
  result["energy_scale"] = report.energy_scale;
  if (report.energy_rise) result["energy_rise"] = number(*report.energy_rise);
  if (report.energy_is_made) result["energy_is_made"] = true;
  if (report.force_imbalance) result["force_imbalance"] = number(*report.force_imbalance);
  if (!report.balance_warning.empty()) result["balance_warning"] = report.balance_warning;
  if (report.friction_lag) result["friction_lag"] = number(*report.friction_lag);
  if (report.friction_is_late) {
    result["friction_is_late"] = true;
    result["friction_advice"] = report.friction_advice;
  }
  result["guess_linear_solves"] = report.guess_linear_solves;
  result["inverted"] = report.inverted;
  result["path_halvings"] = report.path_halvings;
  result["error_table"] = error_table(record);
  record["memory"]["mesh_bytes"] = report.mesh.bytes;
  complete_times(record["time"], report.times);
  return record;
}

}  // namespace trefoil
