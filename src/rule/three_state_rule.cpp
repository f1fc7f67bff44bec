#include <cmath>
#include <limits>

#include "rule/rule.hpp"

namespace trefoil {
namespace {

/// The adaptive rule with a third state: after a clamped step that the model has predicted well,
/// Newton's own direction; back to clamp where the Hessian turns out to be indefinite, and then no
/// other attempt before the decrement has fallen by a factor of `patience`.
class ThreeStateRule final : public Rule {
 public:
  explicit ThreeStateRule(double tolerance) : tolerance_(tolerance) {}

  double first() override {
    refused_decrement_ = std::numeric_limits<double>::infinity();
    return 1;
  }

  double next(const IterationRecord &last) override {
    if (!(std::abs(last.rho - 1) < tolerance_)) return 1;
    const bool try_newton = last.weight <= 0.5 && last.decrement < refused_decrement_ / patience;
    return try_newton ? 0 : 0.5;
  }

  [[nodiscard]] double least_weight() const override { return 0; }
  [[nodiscard]] bool may_be_rejected() const override { return true; }
  std::optional<double> rejected(const IterationRecord &refused) override {
    if (refused.weight >= 0.5) return std::nullopt;
    refused_decrement_ = refused.decrement;
    return 0.5;
  }

  [[nodiscard]] double refused_decrement() const override { return refused_decrement_; }
  void set_refused_decrement(double decrement) override { refused_decrement_ = decrement; }

  [[nodiscard]] bool uses_rho() const override { return true; }

 private:
  static constexpr double patience = 100;
  double tolerance_;
  double refused_decrement_ = std::numeric_limits<double>::infinity();
};

}  // namespace

std::unique_ptr<Rule> make_three_state_rule(const RuleParameters &parameters) {
  return std::make_unique<ThreeStateRule>(parameters.rho_tolerance);
}

}  // namespace trefoil
