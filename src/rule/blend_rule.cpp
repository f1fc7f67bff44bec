#include <cmath>

#include "rule/rule.hpp"

namespace trefoil {
namespace {

/// The adaptive rule without its step: w goes from clamp to absolute with the model's error,
///   w = 1/2 + 1/2 e / (e + tolerance),  e = |rho - 1|.
class BlendRule final : public Rule {
 public:
  explicit BlendRule(double tolerance) : tolerance_(tolerance) {}

  double first() override { return 1; }

  double next(const IterationRecord &last) override {
    const double error = std::abs(last.rho - 1);
    if (!std::isfinite(error)) return 1;  // no evidence for the model
    const double sum = error + tolerance_;
    return sum > 0 ? 0.5 + 0.5 * error / sum : 0.5;
  }

  [[nodiscard]] bool uses_rho() const override { return true; }

 private:
  double tolerance_;
};

}  // namespace

std::unique_ptr<Rule> make_blend_rule(const RuleParameters &parameters) {
  return std::make_unique<BlendRule>(parameters.rho_tolerance);
}

}  // namespace trefoil
