#include "output/saved_states.hpp"

#include <limits>

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

Json save(const Extreme &extreme) {
  return {extreme.value, extreme.at};
}

Extreme load_extreme(const Json &json) {
  return {number_of(json.at(0)), json.at(1).get<std::array<double, 3>>()};
}

Json save(const std::vector<Resultant> &resultants) {
  Json list = Json::array();
  for (const Resultant &resultant : resultants) {
    list.push_back(Json::array({resultant.force, resultant.moment}));
  }
  return list;
}

std::vector<Resultant> load_resultants(const Json &json) {
  std::vector<Resultant> resultants;
  for (const Json &pair : json) {
    resultants.push_back(
        {pair.at(0).get<std::array<double, 3>>(), pair.at(1).get<std::array<double, 3>>()});
  }
  return resultants;
}

Json save(const ContactState &contact) {
  Json json{{"energy", contact.energy},
            {"least_gap", contact.least_gap},
            {"distance", contact.distance},
            {"stiffening", contact.stiffening},
            {"pairs", contact.pairs},
            {"friction_iterations", contact.friction_iterations},
            {"friction_force", contact.friction_force},
            {"friction_change", contact.friction_change},
            {"obstacles", Json::array()}};
  for (const ObstacleReport &obstacle : contact.obstacles) {
    json["obstacles"].push_back(Json::array({obstacle.name, obstacle.force}));
  }
  return json;
}

ContactState load_contact(const Json &json) {
  ContactState contact;
  contact.energy = number_of(json.at("energy"));
  contact.least_gap = json.at("least_gap").is_null() ? std::numeric_limits<double>::infinity()
                                                     : json.at("least_gap").get<double>();
  contact.distance = json.at("distance");
  contact.stiffening = json.at("stiffening");
  contact.pairs = json.at("pairs");
  contact.friction_iterations = json.at("friction_iterations");
  contact.friction_force = json.value("friction_force", 0.);
  contact.friction_change = json.value("friction_change", 0.);
  for (const Json &pair : json.value("obstacles", Json::array())) {
    contact.obstacles.push_back({pair.at(0), pair.at(1).get<std::array<double, 3>>()});
  }
  return contact;
}

Json save(const MotionReport &motion) {
  return {{"step", motion.step},
          {"kinetic_energy", motion.kinetic_energy},
          {"momentum", motion.momentum},
          {"angular_momentum", motion.angular_momentum}};
}

MotionReport load_motion(const Json &json) {
  return {json.at("step"), number_of(json.at("kinetic_energy")),
          json.at("momentum").get<std::array<double, 3>>(),
          json.at("angular_momentum").get<std::array<double, 3>>()};
}

}  // namespace

double number_of(const Json &json) {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
}

Json save(const StateReport &state) {
  Json json{{"t", state.t},
            {"energy", state.energy},
            {"strain_energy", state.strain_energy},
            {"load_work", state.load_work},
            {"iterations", state.iterations},
            {"is_loose", state.is_loose},
            {"reactions", save(state.reactions)},
            {"loads", save(state.loads)},
            {"largest_displacement", save(state.largest_displacement)},
            {"least_determinant", save(state.least_determinant)},
            {"largest_von_mises", save(state.largest_von_mises)},
            {"volume", state.volume},
            {"probes", Json::array()}};
  for (const ProbeReport &probe : state.probes) {
    json["probes"].push_back(Json::array({probe.name, probe.displacement}));
  }
  if (state.motion) json["motion"] = save(*state.motion);
  if (state.contact) json["contact"] = save(*state.contact);
  return json;
}

StateReport load_state(const Json &json) {
  StateReport state;
  state.t = json.at("t");
  state.energy = number_of(json.at("energy"));
  state.strain_energy = number_of(json.at("strain_energy"));
  state.load_work = number_of(json.at("load_work"));
  state.iterations = json.at("iterations");
  state.is_loose = json.at("is_loose");
  state.reactions = load_resultants(json.at("reactions"));
  state.loads = load_resultants(json.at("loads"));
  state.largest_displacement = load_extreme(json.at("largest_displacement"));
  state.least_determinant = load_extreme(json.at("least_determinant"));
  state.largest_von_mises = load_extreme(json.at("largest_von_mises"));
  state.volume = number_of(json.at("volume"));
  for (const Json &probe : json.at("probes")) {
    state.probes.push_back({probe.at(0), probe.at(1).get<std::array<double, 3>>()});
  }
  if (json.contains("motion")) state.motion = load_motion(json.at("motion"));
  if (json.contains("contact")) state.contact = load_contact(json.at("contact"));
  return state;
}

}  // namespace trefoil
