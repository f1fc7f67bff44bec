#include "snes/json_record.hpp"

#include <petsc/private/petscimpl.h>
#include <petscksp.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "hook/matrix_operations.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no NaN and no infinity; null says "does not apply" or "not finite".
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

/// What vouches for the Jacobian of an iteration; null where the filter does.
Json definite_by_json(DefiniteBy by) {
  if (by == DefiniteBy::nothing) return nullptr;
  return by == DefiniteBy::inertia ? "inertia" : "curvature";
}

/// @param offset that the objective leaves out of energies
Json iteration_json(const IterationRecord &entry, double offset) {
  return {{"k", entry.k},
          {"energy", number(entry.energy + offset)},
          {"weight", entry.weight},
          {"rho", number(entry.rho)},
          {"step", entry.step},
          {"truncated", entry.truncated},
          {"refused", entry.refused},
          {"definite_by", definite_by_json(entry.definite_by)},
          {"trials", entry.trials},
          {"corrections", entry.shamanskii_steps},
          {"newton_steps", entry.newton_steps},
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
PetscErrorCode time_json(const PhaseClock &clock, MPI_Comm comm, Json *time) {
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
           {"other", std::max(total - share * named, 0.0)}};  // named may round up
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Bytes, summed over the ranks; the factor's as its package reports them.
PetscErrorCode memory_json(SNES snes, MPI_Comm comm, Mat negative, bool solved, Json *memory) {
  Mat matrix = nullptr, factor = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  PetscBool factored = PETSC_FALSE;
  MatInfo info;
  double peak = 0, matrix_bytes = 0, factor_bytes = 0;
  PetscFunctionBeginUser;
  PetscCall(SNESGetJacobian(snes, nullptr, &matrix, nullptr, nullptr));
  for (Mat stored : {matrix, negative}) {
    if (!stored || is_matrix_free(stored)) continue;
    PetscCall(MatGetInfo(stored, MAT_GLOBAL_SUM, &info));
    // A compressed sparse row matrix keeps a number and a column an entry.
    matrix_bytes += info.nz_allocated * static_cast<double>(sizeof(PetscScalar) + sizeof(PetscInt));
  }
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPGetPC(ksp, &pc));
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factored, PCCHOLESKY,
                                      PCLU, ""));
  if (factored && solved) {
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
Json minimum_json(StationaryPoint end) {
  if (end == StationaryPoint::unknown) return nullptr;
  return end == StationaryPoint::minimum;
}

Json result_json(const SolveRecord &record, double offset) {
  const auto &history = record.history;
  int trials = 0;
  for (const IterationRecord &entry : history) trials += entry.trials;
  const IterationRecord last = history.empty() ? IterationRecord{} : history.back();
  return {{"converged", record.converged},
          {"reason", record.reason},
          {"minimum", minimum_json(record.end)},
          {"error_estimate", number(record.error_estimate)},
          {"linear_residual", number(record.linear_residual)},
          {"saddles_left", record.saddles_left},
          {"verification_solves", record.verification_solves},
          {"iterations", record.iterations},
          {"linear_solves", record.linear_solves},
          {"factorisations", record.factorisations},
          {"line_search_trials", trials},
          {"energy_start",
           number(history.empty() ? IterationRecord::none : history.front().energy + offset)},
          {"energy", number(last.energy + offset)},
          {"energy_rest", nullptr},
          {"energy_scale", number(record.energy_scale)},
          {"gradient_norm", number(last.gradient_norm)},
          {"newton_decrement", number(last.decrement)},
          {"inverted", nullptr}};
}

}  // namespace

PetscErrorCode make_json_record(SNES snes, const std::string &filter,
                                const FilteredJacobian &jacobian, const SolveRecord &record,
                                double energy_offset, std::string *json) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(snes));
  Vec x = nullptr;
  PetscInt unknowns = 0;
  PetscMPIInt ranks = 0;
  Json options, time, memory;
  PetscFunctionBeginUser;
  PetscCall(SNESGetSolution(snes, &x));
  PetscCall(VecGetSize(x, &unknowns));
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  PetscCall(options_json(snes, &options));
  PetscCall(time_json(record.clock, comm, &time));
  PetscCall(memory_json(snes, comm, jacobian.negative(), record.linear_solves > 0, &memory));
  Json history = Json::array();
  for (const IterationRecord &entry : record.history) {
    history.push_back(iteration_json(entry, energy_offset));
  }
  const Json whole{{"schema", 1},
                   {"mesh",
                    {{"vertices", nullptr},  // what only the host knows is null
                     {"elements", jacobian.elements()},
                     {"element", nullptr},
                     {"dofs", nullptr},
                     {"free_dofs", unknowns},
                     {"inverted_at_start", nullptr}}},
                   {"solver",
                    {{"filter", filter},
                     {"ranks", ranks},
                     {"unfiltered_blocks", jacobian.unfiltered().unfiltered()},
                     {"notes", record.notes},
                     {"options", options}}},
                   {"result", result_json(record, energy_offset)},
                   {"time", time},
                   {"memory", memory},
                   {"history", history}};
  *json = whole.dump(1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
