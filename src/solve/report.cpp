#include "solve/report.hpp"

#include "solve/energy_rise.hpp"
#include "solve/force_balance.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode describe_mesh(const Scene &scene, MeshReport *report) {
  const Mesh &mesh = scene.mesh;
  PetscFunctionBeginUser;
  report->vertices = mesh.total_corners;
  report->nodes = mesh.total_vertices;
  report->elements = mesh.total_cells;
  report->parts = mesh.parts;
  report->element = mesh.element_name();
  report->element_pressure = scene.options.element_pressure;
  report->dofs = mesh.dimension() * mesh.total_vertices;
  report->free_dofs = scene.discretization.total_dofs();
  report->edge_cut = mesh.edge_cut;
  report->imbalance = mesh.imbalance;
  report->bytes = mesh.bytes() + scene.discretization.bytes() + scene.functional->bytes();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &report->bytes, 1, MPI_DOUBLE, MPI_SUM,
                             PetscObjectComm(reinterpret_cast<PetscObject>(mesh.dm))));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Says where a pressure that follows the body does more at a free rim than push: the body is then
/// in balance with what is no pressure there. Collective.
PetscErrorCode warn_of_loose_rims(const Scene &scene, std::vector<std::string> *warnings) {
  const double much = 1e-3;
  Vec local = nullptr;
  const PetscScalar *u = nullptr;
  double share = 0;
  char percent[32];
  PetscFunctionBeginUser;
  PetscCall(scene.discretization.get_local(scene.displacement, &local, &u));
  PetscCall(scene.loads.share_of_loose_rims(u, scene.discretization.global_dofs(), &share));
  PetscCall(scene.discretization.restore_local(&local, &u));
  if (share <= much) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscSNPrintf(percent, sizeof percent, "%.2g", 100 * share));
  warnings->push_back(
      std::string("a pressure that follows the body ends at a rim that is free, where it has no "
                  "potential: forces at the rim of ") +
      percent +
      " % of its own are added, by which reactions and loads differ; let it end where the body is "
      "held, or at a plane of symmetry, or leave out -load_NAME_follower");
  PetscCall(PetscPrintf(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm)),
                        "WARNING: %s\n", warnings->back().c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What to do where friction lags too far behind with -contact_friction_iterations as they are.
std::string advice_on_friction(PetscInt iterations, bool is_in_time) {
  const std::string shorter =
      std::string("shorter ") + (is_in_time ? "steps in time" : "load steps");
  if (iterations < 0) return "take " + shorter;
  if (iterations == 0 || iterations >= 3) {
    return "take -contact_friction_iterations -1, until they fit, or " + shorter;
  }
  return "take -contact_friction_iterations 3, or -1, until they fit, or " + shorter;
}

/// How much of all states' friction would be other if it had each state's own normal forces, not
/// those of the state before; nothing where there is no friction.
std::optional<double> find_friction_lag(const std::vector<StateReport> &states) {
  double force = 0, change = 0;
  for (const StateReport &state : states) {
    if (!state.contact) continue;
    force += state.contact->friction_force;
    change += state.contact->friction_change;
  }
  return force > 0 ? std::optional(change / force) : std::nullopt;
}

/// Not in time, where inertia is a force as well, and not with contact, whose friction is that of
/// the next solve by now. Collective.
PetscErrorCode check_balance(const Scene &scene, const SolveOutcome &outcome, RunReport *report) {
  ForceBalance balance;
  PetscFunctionBeginUser;
  if (scene.motion || scene.contact) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(find_force_balance(scene, report->end, &balance));
  report->force_imbalance = balance.share;
  if (!outcome.converged) PetscFunctionReturn(PETSC_SUCCESS);
  report->balance_warning = warn_of_imbalance(scene, balance);
  if (!report->balance_warning.empty()) report->warnings.push_back(report->balance_warning);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode fill_report(Scene &scene, const SolveOutcome &outcome, const StateReport &end,
                           RunReport *report) {
  PetscFunctionBeginUser;
  PetscCall(describe_mesh(scene, &report->mesh));
  report->mesh.inverted_at_start = outcome.inverted_at_start;
  report->plugin_record = outcome.plugin_record;
  report->restarted_from = scene.options.checkpoint.restart_file;
  report->linear_solver = outcome.linear_solver;
  report->linear_solver_reason = scene.linear_solver.reason;
  report->failure = outcome.failure;
  report->end = end;
  report->constraints = scene.constraints.reports();
  for (std::size_t k = 0; k < report->constraints.size(); ++k) {
    report->constraints[k].reaction = end.reactions[k];
  }
  report->loads = scene.load_reports;
  for (std::size_t k = 0; k < report->loads.size(); ++k) {
    report->loads[k].resultant = end.loads[k];
  }
  report->regions = scene.regions;
  report->warnings = scene.warnings;
  PetscCall(warn_of_loose_rims(scene, &report->warnings));
  if (scene.motion) {
    report->energy_rise = find_energy_rise(report->states);
    PetscCall(is_energy_made(scene, report->states, *report->energy_rise, &report->energy_is_made));
  }
  PetscCall(check_balance(scene, outcome, report));
  if (report->energy_is_made) {
    report->warnings.push_back(
        "the total energy has risen although nothing drives the scene, so the motion is wrong: "
        "take -time_integrator bdf2 or backward_euler, which damp, or a shorter -time_step");
  }
  report->friction_lag = find_friction_lag(report->states);
  report->friction_is_late = report->friction_lag > tolerated_friction_lag;
  if (report->friction_is_late) {
    report->friction_advice =
        advice_on_friction(scene.options.contact.friction_iterations, scene.options.time.is_on);
    report->warnings.push_back(
        "friction has normal forces of the state before that are too far from a state's own: " +
        report->friction_advice);
  }
  if (outcome.inverted > 0) {
    report->warnings.push_back(std::to_string(outcome.inverted) +
                               (outcome.inverted == 1 ? " element is" : " elements are") +
                               " inverted at the end: det F <= 0");
  }
  report->energy_rest = outcome.energy_rest;
  report->energy_scale = outcome.energy_scale;
  report->guess_linear_solves = outcome.guess.linear_solves;
  report->inverted = outcome.inverted;
  report->path_halvings = outcome.path_halvings;
  for (StateReport &state : report->states) {
    state.is_rejected = state.is_loose && outcome.path_is_rejected;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
