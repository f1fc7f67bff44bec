#include "rule/rule.hpp"

#include <algorithm>
#include <utility>

namespace trefoil {
namespace {

using Registry = std::vector<std::pair<std::string, RuleFactory>>;

/// A new rule of ours is one file and one line here.
Registry own_rules() {
  return {
      {"newton", make_newton_rule},
      {"clamp", make_clamp_rule},
      {"absolute", make_absolute_rule},
      {"adaptive", make_adaptive_rule},
      {"constant", make_constant_rule},
      {"on_demand", make_on_demand_rule},
      {"blend", make_blend_rule},
      {"three_state", make_three_state_rule},
      {"newton_first", make_newton_first_rule},
      {"multiplicative", make_multiplicative_rule},
      {"tikhonov", make_tikhonov_rule},
  };
}

/// Never destroyed: a host may finalise PETSc from a destructor of its own, after ours.
Registry &registry() {
  static auto &rules = *new Registry(own_rules());
  return rules;
}

}  // namespace

std::unique_ptr<Rule> make_rule(const std::string &name, const RuleParameters &parameters) {
  for (const auto &[known, factory] : registry()) {
    if (name == known) return factory(parameters);
  }
  return nullptr;
}

std::vector<std::string> rule_names() {
  std::vector<std::string> names;
  for (const auto &entry : registry()) names.push_back(entry.first);
  return names;
}

bool register_rule(const std::string &name, RuleFactory factory) {
  const auto names = rule_names();
  if (std::find(names.begin(), names.end(), name) != names.end()) return false;
  registry().emplace_back(name, std::move(factory));
  return true;
}

void forget_registered_rules() {
  registry() = own_rules();
}

}  // namespace trefoil
