#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "rule/iteration_record.hpp"

namespace trefoil {

/// Numbers that a rule may be tuned by.
struct RuleParameters {
  double rho_tolerance = 0.01;  ///< -snes_trefoil_rho_tolerance, the paper's epsilon
  double weight = 1;            ///< -snes_trefoil_weight, for rule `constant`
  void *solver = nullptr;       ///< the SNES, for rules that hosts register
};

/// Chooses the filter weight w of every iteration: H + 2 w N, w = 0 Newton, 1/2 clamp, 1 absolute.
class Rule {
 public:
  virtual ~Rule() = default;
  /// The weight of a solve's first iteration. Also forgets whatever was learned in a solve before.
  virtual double first() = 0;
  /// The weight of the iteration after `last`, whose step has been taken.
  virtual double next(const IterationRecord &last) = 0;
  /// The floor under filtered eigenvalues, as a share of the element's largest; 0: none.
  [[nodiscard]] virtual double floor() const { return 0; }
  /// The least weight it may choose: below 1/2 the Jacobian may be indefinite.
  [[nodiscard]] virtual double least_weight() const { return 0.5; }
  /// Whether it looks at the trust-region ratio, and so at -snes_trefoil_rho_tolerance.
  [[nodiscard]] virtual bool uses_rho() const { return false; }
  /// Whether the direction is to be Newton's as far as the Hessian is positive along the way.
  [[nodiscard]] virtual bool prefers_newton() const { return false; }
  /// Whether it chooses weights with which the Jacobian may be indefinite, and knows what then.
  [[nodiscard]] virtual bool may_be_rejected() const { return false; }
  /// The weight to try instead of that of the iteration under way, whose Jacobian turned out to be
  /// indefinite; none: the solve ends there.
  virtual std::optional<double> rejected(const IterationRecord &) { return std::nullopt; }
  /// The decrement with which its last Jacobian turned out to be indefinite, where that keeps it
  /// from another attempt; infinity: nothing does. A solve that goes on from a file gives it back.
  [[nodiscard]] virtual double refused_decrement() const {
    return std::numeric_limits<double>::infinity();
  }
  virtual void set_refused_decrement(double) {}
  /// What the last answer has failed with, a host's own error code; 0: nothing.
  [[nodiscard]] virtual int error() const { return 0; }
};

/// A rule by its name; null where there is none of that name.
std::unique_ptr<Rule> make_rule(const std::string &name, const RuleParameters &parameters);

/// The names make_rule() knows, in the order in which -help lists them.
std::vector<std::string> rule_names();

using RuleFactory = std::function<std::unique_ptr<Rule>(const RuleParameters &)>;

/// Adds a rule to those that make_rule() knows; false where the name is taken.
bool register_rule(const std::string &name, RuleFactory factory);
/// Forgets the rules that were added, with the types that PETSc forgets.
void forget_registered_rules();

// One function a file of rules; the registry in rule.cpp lists them.
std::unique_ptr<Rule> make_newton_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_clamp_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_absolute_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_constant_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_adaptive_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_on_demand_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_blend_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_three_state_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_newton_first_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_multiplicative_rule(const RuleParameters &parameters);
std::unique_ptr<Rule> make_tikhonov_rule(const RuleParameters &parameters);

}  // namespace trefoil
