#include <algorithm>
#include <cmath>

#include "rule/rule.hpp"

namespace trefoil {
namespace {

/// w as a trust region treats its radius: halved after a step that the model has predicted well,
/// doubled after one that it has not, between `least` and `most`. A Hessian that is indefinite with
/// a weight below 1/2 doubles it as well.
class MultiplicativeRule final : public Rule {
 public:
  explicit MultiplicativeRule(double tolerance) : tolerance_(tolerance) {}

  double first() override { return 1; }

  double next(const IterationRecord &last) override {
    const bool predicted = std::abs(last.rho - 1) < tolerance_;
    return std::clamp(last.weight * (predicted ? 0.5 : 2.0), least, most);
  }

  [[nodiscard]] double least_weight() const override { return least; }
  [[nodiscard]] bool may_be_rejected() const override { return true; }
  std::optional<double> rejected(const IterationRecord &refused) override {
    if (refused.weight >= 0.5) return std::nullopt;
    return std::min(2 * refused.weight, 0.5);
  }

  [[nodiscard]] bool uses_rho() const override { return true; }

 private:
  static constexpr double least = 0.125, most = 4;
  double tolerance_;
};

}  // namespace

std::unique_ptr<Rule> make_multiplicative_rule(const RuleParameters &parameters) {
  return std::make_unique<MultiplicativeRule>(parameters.rho_tolerance);
}

}  // namespace trefoil
