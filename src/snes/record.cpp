#include <petsc/private/petscimpl.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "snes/solve_context.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no NaN and no infinity; null says "does not apply" or "not finite".
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// @param offset that the objective leaves out of energies
Json iteration_json(const IterationRecord &entry, double offset) {
  return {{"k", entry.k},
          {"energy", number(entry.energy + offset)},
          {"weight", entry.weight},
          {"rho", number(entry.rho)},
          {"step", entry.step},
          {"trials", entry.trials},
          {"corrections", entry.corrections},
          {"decrement", number(entry.decrement)},
          {"gradient_norm", number(entry.gradient_norm)},
          {"indefinite", number(entry.indefinite)},
          {"linear_iterations", entry.linear_iterations},
          {"linear_solves", entry.linear_solves},
          {"seconds", entry.seconds}};
}

/// Values of the options that nothing has asked for yet: to look these up would mark them as used.
PetscErrorCode unused_options(PetscOptions database, std::map<std::string, std::string> *unused) {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscOptionsLeftGet(database, &count, &names, &values));
  for (PetscInt i = 0; i < count; ++i) (*unused)[names[i]] = values[i] ? values[i] : "";
  PetscCall(PetscOptionsLeftRestore(database, &count, &names, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Every option of the run as the user gave it. PETSc lists them in one line, "-name value -name ",
/// where only the length of a value tells whether a " -" in it begins a name.
PetscErrorCode options_json(SNES snes, Json *options) {
  PetscOptions database = nullptr;
  std::map<std::string, std::string> unused;
  char *all = nullptr;
  PetscFunctionBeginUser;
  PetscCall(PetscObjectGetOptions(reinterpret_cast<PetscObject>(snes), &database));
  PetscCall(unused_options(database, &unused));
  PetscCall(PetscOptionsGetAll(database, &all));
  const std::string text = all;
  PetscCall(PetscFree(all));
  *options = Json::object();
  for (std::size_t at = 0; (at = text.find_first_not_of(' ', at)) != std::string::npos;) {
    const std::string option = text.substr(at, text.find(' ', at) - at), name = option.substr(1);
    std::string value;
    if (const auto left = unused.find(name); left != unused.end()) {
      value = left->second;
    } else {
      const char *used = nullptr;
      PetscBool found = PETSC_FALSE;
      PetscCall(PetscOptionsFindPair(database, nullptr, option.c_str(), &used, &found));
      if (found && used) value = used;
    }
    (*options)[name] = value;
    at += option.size() + 1 + value.size();
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Seconds by phase, the maximum over the ranks. Filter and assembly are one phase to the ranks
/// that wait for each other, so assembly is the maximum of both together less the filter's. Where
/// ranks wait in different phases the maxima would add up to more than the whole: then they share
/// it.
PetscErrorCode time_json(const SolveContext &context, MPI_Comm comm, Json *time) {
  const PhaseClock &clock = context.clock;
  const double filter = clock.seconds(Phase::filter);
  double seconds[5] = {filter, filter + clock.seconds(Phase::assembly),
                       clock.seconds(Phase::linear_solve), clock.seconds(Phase::line_search),
                       clock.seconds(Phase::other)};
  PetscFunctionBeginUser;
  double total = seconds[1] + seconds[2] + seconds[3] + seconds[4];
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seconds, 4, MPI_DOUBLE, MPI_MAX, comm));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_DOUBLE, MPI_MAX, comm));
  const double named = seconds[1] + seconds[2] + seconds[3];
  const double share = named > total ? total / named : 1;
  *time = {{"total", total},
           {"read", 0.0},
           {"setup", 0.0},
           {"assembly", share * (seconds[1] - seconds[0])},
           {"filter", share * seconds[0]},
           {"linear_solve", share * seconds[2]},
           {"line_search", share * seconds[3]},
           {"output", 0.0},
           {"other", total - share * named}};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Bytes, summed over the ranks; the factor's as its package reports them.
PetscErrorCode memory_json(const SolveContext &context, MPI_Comm comm, Json *memory) {
  const SNES snes = context.snes;
  Mat matrix = nullptr, factor = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  PetscBool factored = PETSC_FALSE;
  MatInfo info;
  double peak = 0, matrix_bytes = 0, factor_bytes = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESGetJacobian(snes, nullptr, &matrix, nullptr, nullptr));
  for (Mat stored : {matrix, context.negative}) {
    if (!stored) continue;
    PetscCall(MatGetInfo(stored, MAT_GLOBAL_SUM, &info));
    // A compressed sparse row matrix keeps a number and a column an entry.
    matrix_bytes += info.nz_allocated * static_cast<double>(sizeof(PetscScalar) + sizeof(PetscInt));
  }
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factored, PCCHOLESKY,
                                      PCLU, ""));
  if (factored && context.summary.linear_solves > 0) {
    MatSolverType solver = nullptr;
    PetscBool mumps = PETSC_FALSE;
    PetscBool informed = PETSC_FALSE;
    PetscCall(PCFactorGetMatrix(pc, &factor));
    if (factor) PetscCall(MatHasOperation(factor, MATOP_GETINFO, &informed));
    if (informed) {
      PetscCall(MatFactorGetSolverType(factor, &solver));
      PetscCall(PetscStrcmp(solver, MATSOLVERMUMPS, &mumps));
      if (!mumps) {
        PetscCall(MatGetInfo(factor, MAT_GLOBAL_SUM, &info));
        factor_bytes = info.memory;
      }
#if defined(PETSC_HAVE_MUMPS)
      if (mumps) {  // INFOG(22): megabytes in use during the factorisation, all ranks
        PetscInt megabytes = 0;
        PetscCall(MatMumpsGetInfog(factor, 22, &megabytes));
        factor_bytes = 1e6 * static_cast<double>(megabytes);
      }
#endif
    }
  }
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  peak = 1024.0 * static_cast<double>(usage.ru_maxrss);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &peak, 1, MPI_DOUBLE, MPI_SUM, comm));
  *memory = {{"peak_bytes", peak},
             {"mesh_bytes", 0},
             {"matrix_bytes", matrix_bytes},
             {"factor_bytes", factor_bytes}};
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Whether the end is a minimum; null where that is not known.
Json minimum_json(const SolveSummary &summary) {
  if (summary.end == StationaryPoint::unknown) return nullptr;
  return summary.end == StationaryPoint::minimum;
}

Json result_json(const SolveContext &context) {
  const auto &history = context.history;
  const double offset = context.energy_offset;
  int trials = 0;
  for (const IterationRecord &entry : history) trials += entry.trials;
  const IterationRecord last = history.empty() ? IterationRecord{} : history.back();
  return {{"converged", context.summary.converged},
          {"reason", context.summary.reason},
          {"minimum", minimum_json(context.summary)},
          {"error_estimate", number(context.summary.error_estimate)},
          {"saddles_left", context.summary.saddles_left},
          {"verification_solves", context.summary.verification_solves},
          {"iterations", context.summary.iterations},
          {"linear_solves", context.summary.linear_solves},
          {"line_search_trials", trials},
          {"energy_start",
           number(history.empty() ? IterationRecord::none : history.front().energy + offset)},
          {"energy", number(last.energy + offset)},
          {"energy_rest", nullptr},
          {"energy_scale", number(context.summary.energy_scale)},
          {"gradient_norm", number(last.gradient_norm)},
          {"newton_decrement", number(last.decrement)},
          {"inverted", nullptr}};
}

/// After the last step, where PETSc's own tests ended the solve, the history still lacks the state
/// that was reached.
PetscErrorCode close_history(SolveContext &context) {
  Vec x = nullptr, residual = nullptr;
  PetscFunctionBeginUser;
  if (!context.history.empty() && context.history.back().step == 0 && context.driven) {
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  IterationRecord last;
  last.k = context.history.empty() ? 0 : context.history.back().k + 1;
  last.weight = context.current.weight;
  last.indefinite = IterationRecord::none;
  last.linear_solves = context.summary.linear_solves;
  last.seconds = context.head_start + context.clock.elapsed();
  PetscCall(SNESGetSolution(context.snes, &x));
  PetscCall(energy_at(context, x, &last.energy));
  PetscCall(SNESGetFunction(context.snes, &residual, nullptr, nullptr));
  PetscCall(VecNorm(residual, NORM_2, &last.gradient_norm));
  context.history.push_back(last);
  PetscCall(monitor_iteration(context, last));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode make_record(SolveContext &context, std::string *json) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(context.snes));
  Vec x = nullptr;
  PetscInt unknowns = 0;
  PetscMPIInt ranks = 0;
  Json options, time, memory;
  PetscFunctionBeginUser;
  PetscCall(SNESGetSolution(context.snes, &x));
  PetscCall(VecGetSize(x, &unknowns));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(options_json(context.snes, &options));
  PetscCall(time_json(context, comm, &time));
  PetscCall(memory_json(context, comm, &memory));
  Json history = Json::array();
  for (const IterationRecord &entry : context.history) {
    history.push_back(iteration_json(entry, context.energy_offset));
  }
  const Json record{{"schema", 1},
                    {"mesh",
                     {{"vertices", nullptr},  // what only the host knows is null
                      {"elements", context.elements},
                      {"element", nullptr},
                      {"dofs", nullptr},
                      {"free_dofs", unknowns},
                      {"inverted_at_start", nullptr}}},
                    {"solver",
                     {{"filter", context.driven ? context.options.filter : "none"},
                      {"ranks", ranks},
                      {"unfiltered_blocks", context.unfiltered.unfiltered()},
                      {"options", options}}},
                    {"result", result_json(context)},
                    {"time", time},
                    {"memory", memory},
                    {"history", history}};
  *json = record.dump(1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode end_solve(SolveContext &context) {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(context.snes));
  PetscFunctionBeginUser;
  if (!context.running) PetscFunctionReturn(PETSC_SUCCESS);
  context.clock.switch_to(Phase::other);
  PetscCall(SNESGetConvergedReason(context.snes, &reason));
  context.summary.converged = reason > 0;
  if (context.summary.reason.empty()) {
    const char *text = nullptr;
    PetscCall(SNESGetConvergedReasonString(context.snes, &text));
    context.summary.reason = text;
    if (reason == SNES_DIVERGED_MAX_IT) {
      context.summary.reason = "DIVERGED_MAX_IT: no tolerance is met after -snes_max_it iterations";
    }
    if (reason == SNES_DIVERGED_LINEAR_SOLVE) {  // FACTOR_OUTMEMORY, FACTOR_NUMERIC_ZEROPIVOT ...
      KSP ksp = nullptr;
      PC pc = nullptr;
      PCFailedReason failure = PC_NOERROR;
      PetscCall(SNESGetKSP(context.snes, &ksp));
      PetscCall(KSPGetPC(ksp, &pc));
      PetscCall(PCGetFailedReason(pc, &failure));
      if (failure) context.summary.reason += std::string(": ") + PCFailedReasons[failure];
    }
  }
  PetscCall(close_history(context));
  if (context.energy_scale) {
    Vec x = nullptr;
    PetscReal scale = 0;
    PetscCall(SNESGetSolution(context.snes, &x));
    PetscCall(context.energy_scale(context.snes, x, &scale, context.energy_scale_context));
    context.summary.energy_scale = scale;
  }
  context.clock.switch_to(Phase::other);
  PetscCall(make_record(context, &context.record));
  if (!context.options.record_file.empty()) {
    PetscCall(write_text_file(comm, context.options.record_file, context.record + "\n"));
  }
  context.running = false;
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
