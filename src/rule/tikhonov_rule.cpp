#include "rule/rule.hpp"

namespace trefoil {
namespace {

/// Absolute eigenvalues that are not below a threshold (Paternain, Mokhtari and Ribeiro 2019, "A
/// Newton-based method for nonconvex optimization with fast evasion of saddle points"), element by
/// element and relative to the element's own scale. -snes_trefoil_floor is the threshold.
class TikhonovRule final : public Rule {
 public:
  double first() override { return 1; }
  double next(const IterationRecord &) override { return 1; }
  [[nodiscard]] double floor() const override { return 1e-3; }
};

}  // namespace

std::unique_ptr<Rule> make_tikhonov_rule(const RuleParameters &) {
  return std::make_unique<TikhonovRule>();
}

}  // namespace trefoil
