#include <cmath>

#include "rule/rule.hpp"

namespace trefoil {
namespace {

constexpr double clamp = 0.5;
constexpr double absolute = 1.0;

/// Chen et al. 2024, "Trust-region eigenvalue filtering for projected Newton", section 4.3: clamp
/// where the last quadratic model predicted the energy well, |rho - 1| < tolerance, else absolute;
/// absolute in the first iteration. (Strictly less, as in the authors' code; their text has <=.)
class AdaptiveRule final : public Rule {
 public:
  explicit AdaptiveRule(double tolerance) : tolerance_(tolerance) {}

  double first() override { return absolute; }

  double next(const IterationRecord &last) override {
    // A ratio that is not a number compares false: no evidence for the model, so absolute.
    return std::abs(last.rho - 1) < tolerance_ ? clamp : absolute;
  }

  [[nodiscard]] bool uses_rho() const override { return true; }

 private:
  double tolerance_;
};

}  // namespace

std::unique_ptr<Rule> make_adaptive_rule(const RuleParameters &parameters) {
  return std::make_unique<AdaptiveRule>(parameters.rho_tolerance);
}

}  // namespace trefoil
