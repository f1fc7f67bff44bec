#include "rule/rule.hpp"

namespace trefoil {
namespace {

/// Longva et al. 2023, "Pitfalls of projection: a study of Newton-type solvers for incremental
/// potentials": Newton's own direction, and projection (clamp) only where the Hessian's Cholesky
/// factorisation finds it indefinite.
class OnDemandRule final : public Rule {
 public:
  double first() override { return 0; }
  double next(const IterationRecord &) override { return 0; }
  [[nodiscard]] double least_weight() const override { return 0; }
  [[nodiscard]] bool may_be_rejected() const override { return true; }
  std::optional<double> rejected(const IterationRecord &refused) override {
    return refused.weight < 0.5 ? std::optional(0.5) : std::nullopt;
  }
};

}  // namespace

std::unique_ptr<Rule> make_on_demand_rule(const RuleParameters &) {
  return std::make_unique<OnDemandRule>();
}

}  // namespace trefoil
