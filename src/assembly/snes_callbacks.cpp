// What SNES calls, and how it comes to know it.

#include <algorithm>

#include "assembly/energy_functional.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode objective(SNES, Vec x, PetscReal *energy, void *ctx) {
  EnergySums sums;
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->energy(x, &sums));
  *energy = sums.energy;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode residual(SNES, Vec x, Vec g, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->gradient(x, g));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode split_hessian(SNES snes, Vec x, Mat H, Mat *negative,
                             TrefoilSplitStatistics *statistics, void *ctx) {
  HessianFilter filter;
  PetscFunctionBeginUser;
  PetscCall(TrefoilSNESGetWeight(snes, &filter.weight));
  PetscCall(TrefoilSNESGetEigenvalueFloor(snes, &filter.floor.share, &filter.floor.weight));
  if (!negative && filter.weight != 0) {
    PetscCall(
        static_cast<EnergyFunctional *>(ctx)->filtered_hessian(x, H, statistics, filter.weight));
  } else {
    PetscCall(static_cast<EnergyFunctional *>(ctx)->hessian(x, H, negative, statistics, filter));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode hessian_product(SNES, Vec p, Vec Hp, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->multiply_by_hessian(p, Hp));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode plain_hessian(SNES, Vec x, Mat, Mat H, void *ctx) {
  TrefoilSplitStatistics ignored{};
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->hessian(x, H, nullptr, &ignored));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode changes_on_plane(SNES, Vec x, PetscInt directions, const Vec d[], PetscInt points,
                                const PetscReal coefficients[], PetscReal changes[], void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->energy_changes(x, directions, d, points,
                                                                 coefficients, changes));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode max_step(SNES, Vec x, Vec d, PetscReal first, PetscReal *largest, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->largest_step(x, d, first, largest));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode direction_size(SNES, Vec d, PetscReal *size, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->largest_move(d, size));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode mass_proxy(SNES, Mat P, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->constant_hessian(P));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode energy_scale(SNES, Vec x, PetscReal *scale, void *ctx) {
  PetscFunctionBeginUser;
  PetscCall(static_cast<EnergyFunctional *>(ctx)->size_of_energy(x, scale));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode EnergyFunctional::attach(SNES snes, Mat H, Assembly assembly) {
  const bool whole = std::any_of(terms_.begin(), terms_.end(), [](const auto &term) {
    return term->batch() && term->batch()->filter_space() == FilterSpace::element;
  });
  double at_rest = 0;
  PetscFunctionBeginUser;
  PetscCall(energy_at_rest(&at_rest));
  PetscCall(TrefoilSNESSetEnergyOffset(snes, at_rest));
  hessian_.go_one_by_one(assembly != Assembly::split);
  PetscCall(SNESSetObjective(snes, objective, this));
  PetscCall(SNESSetFunction(snes, nullptr, residual, this));
  if (assembly != Assembly::hook) {
    PetscCall(TrefoilSNESSetSplitJacobian(snes, H, split_hessian, this));
    PetscCall(TrefoilSNESSetSplitCapabilities(
        snes, TREFOIL_SPLIT_FLOOR | (whole ? 0 : TREFOIL_SPLIT_DEFORMATION)));
  } else {
    PetscCall(SNESSetJacobian(snes, H, H, plain_hessian, this));
  }
  PetscCall(TrefoilSNESSetEnergyScale(snes, energy_scale, this));
  PetscCall(TrefoilSNESSetEnergyChanges(snes, changes_on_plane, this));
  PetscCall(TrefoilSNESSetDirectionSize(snes, direction_size, this));
  if (std::any_of(terms_.begin(), terms_.end(),
                  [](const auto &term) { return term->hessian_kind() == HessianKind::constant; })) {
    PetscCall(TrefoilSNESSetMassProxy(snes, mass_proxy, this));
  }
  if (std::any_of(terms_.begin(), terms_.end(),
                  [](const auto &term) { return term->limits_step(); })) {
    PetscCall(TrefoilSNESSetMaxStep(snes, max_step, this));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode EnergyFunctional::do_without_negative(SNES snes) {
  PetscFunctionBeginUser;
  if (hessian_has_product()) PetscCall(TrefoilSNESSetHessianProduct(snes, hessian_product, this));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
