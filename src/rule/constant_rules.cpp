#include "rule/rule.hpp"

namespace trefoil {
namespace {

/// The same weight in every iteration.
class ConstantRule final : public Rule {
 public:
  explicit ConstantRule(double weight) : weight_(weight) {}
  double first() override { return weight_; }
  double next(const IterationRecord &) override { return weight_; }
  [[nodiscard]] double least_weight() const override { return weight_; }

 private:
  double weight_;
};

}  // namespace

/// Newton's method: the Hessian as it is.
std::unique_ptr<Rule> make_newton_rule(const RuleParameters &) {
  return std::make_unique<ConstantRule>(0.0);
}

/// Negative eigenvalues set to zero (Teran et al. 2005, "Robust quasistatic finite elements and
/// flesh simulation").
std::unique_ptr<Rule> make_clamp_rule(const RuleParameters &) {
  return std::make_unique<ConstantRule>(0.5);
}

/// Negative eigenvalues replaced by their absolute values (Chen et al. 2024, "Stabler Neo-Hookean
/// simulation: absolute eigenvalue filtering for projected Newton").
std::unique_ptr<Rule> make_absolute_rule(const RuleParameters &) {
  return std::make_unique<ConstantRule>(1.0);
}

/// The user's own weight.
std::unique_ptr<Rule> make_constant_rule(const RuleParameters &parameters) {
  return std::make_unique<ConstantRule>(parameters.weight);
}

}  // namespace trefoil
