#include <petscsnes.h>

#include <string>

#include "rule/rule.hpp"
#include "snes/solver.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil.h"

namespace trefoil {
namespace {

/// A rule that a host has registered through the C API.
class UserRule final : public Rule {
 public:
  UserRule(SNES snes, TrefoilRuleFunction function, void *context)
      : snes_(snes), function_(function), context_(context) {}

  double first() override { return ask(nullptr); }

  double next(const IterationRecord &last) override {
    const TrefoilIteration iteration = as_hosts_see(last);
    return ask(&iteration);
  }

  /// It may choose any.
  [[nodiscard]] double least_weight() const override { return 0; }
  [[nodiscard]] bool uses_rho() const override { return true; }
  [[nodiscard]] int error() const override { return error_; }

 private:
  double ask(const TrefoilIteration *last) {
    PetscReal weight = 0;
    error_ = static_cast<int>(function_(snes_, last, &weight, context_));
    return weight;
  }

  SNES snes_;
  TrefoilRuleFunction function_;
  void *context_;
  int error_ = 0;
};

}  // namespace
}  // namespace trefoil

PetscErrorCode TrefoilRuleRegister(const char name[], TrefoilRuleFunction function, void *ctx) {
  PetscFunctionBegin;
  PetscCall(TrefoilInitializePackage());
  const bool added = trefoil::register_rule(name, [function,
                                                   ctx](const trefoil::RuleParameters &parameters) {
    return std::make_unique<trefoil::UserRule>(static_cast<SNES>(parameters.solver), function, ctx);
  });
  PetscCheck(added, PETSC_COMM_SELF, PETSC_ERR_ARG_WRONG, "there is a rule '%s' already", name);
  PetscFunctionReturn(PETSC_SUCCESS);
}
