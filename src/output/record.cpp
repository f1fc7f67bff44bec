#include <cmath>
#include <nlohmann/json.hpp>

#include "output/error_table.hpp"
#include "output/result.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

using Json = nlohmann::ordered_json;

PetscErrorCode mesh_bytes(const Scene &scene, MPI_Comm comm, double *bytes) {
  PetscFunctionBeginUser;
  *bytes = scene.mesh.bytes() + scene.discretization.bytes() + scene.functional->bytes();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, bytes, 1, MPI_DOUBLE, MPI_SUM, comm));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the plugin counted as `other` is its part of the program's remainder. Waiting, which is in
/// the maxima of several phases, must not make them more than the whole.
void complete_times(Json &time, const ProgramTimes &times) {
  time["read"] = times.read;
  time["setup"] = times.setup;
  time["guess"] = times.guess;
  time["output"] = times.output;
  const char *phases[] = {"read",   "setup",        "guess",       "assembly",
                          "filter", "linear_solve", "line_search", "output"};
  double named = 0;
  for (const char *phase : phases) named += time[phase].get<double>();
  const double share = named > times.total ? times.total / named : 1;
  for (const char *phase : phases) time[phase] = share * time[phase].get<double>();
  time["total"] = times.total;
  time["other"] = times.total - share * named;
}

}  // namespace

PetscErrorCode complete_record(const Scene &scene, const SolveOutcome &outcome,
                               const ProgramTimes &times, std::string *json) {
  const auto comm = PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm));
  double seconds[5] = {times.total, times.read, times.setup, times.output, outcome.guess.seconds},
         bytes = 0;
  PetscFunctionBeginUser;
  PetscCall(mesh_bytes(scene, comm, &bytes));
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, seconds, 5, MPI_DOUBLE, MPI_MAX, comm));
  Json record = Json::parse(outcome.plugin_record, nullptr, false);
  PetscCheck(record.is_object(), comm, PETSC_ERR_PLIB, "the solver left no record");
  record["mesh"] = {{"vertices", scene.mesh.total_corners},
                    {"nodes", scene.mesh.total_vertices},
                    {"elements", scene.mesh.total_cells},
                    {"parts", scene.mesh.parts},
                    {"element", scene.mesh.element_name()},
                    {"dofs", scene.mesh.dimension() * scene.mesh.total_vertices},
                    {"free_dofs", scene.discretization.total_dofs()},
                    {"inverted_at_start", outcome.inverted_at_start},
                    {"edge_cut", scene.mesh.edge_cut},
                    {"imbalance", scene.mesh.imbalance}};
  record["constraints"] = Json::array();
  for (const ConstraintReport &report : scene.constraints.reports()) {
    record["constraints"].push_back(
        {{"name", report.name}, {"vertices", report.vertices}, {"area", report.area}});
  }
  record["loads"] = Json::array();
  for (const LoadReport &report : scene.load_reports) {
    record["loads"].push_back({{"name", report.name},
                               {"facets", report.facets},
                               {"area", report.area},
                               {"force", report.resultant.force}});
  }
  record["result"]["warnings"] = scene.warnings;
  record["result"]["energy_rest"] = outcome.energy_rest;
  record["result"]["energy_scale"] = outcome.energy_scale;
  record["result"]["guess_linear_solves"] = outcome.guess.linear_solves;
  record["result"]["inverted"] = outcome.inverted;
  record["result"]["error_table"] = error_table(record);
  record["memory"]["mesh_bytes"] = bytes;
  complete_times(record["time"], {seconds[0], seconds[1], seconds[2], seconds[3], seconds[4]});
  *json = record.dump(1);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode print_summary(MPI_Comm comm, const std::string &json) {
  PetscFunctionBeginUser;
  const Json record = Json::parse(json);
  const Json &result = record["result"], &time = record["time"];
  const auto number = [](const Json &value) {
    return value.is_number() ? value.get<double>() : std::nan("");
  };
  PetscCall(PetscPrintf(comm, "%s in %d iterations, %d line-search trials: %s\n",
                        result["converged"].get<bool>() ? "converged" : "NOT CONVERGED",
                        result["iterations"].get<int>(), result["line_search_trials"].get<int>(),
                        result["reason"].get<std::string>().c_str()));
  PetscCall(PetscPrintf(comm, "energy %.14g, gradient norm %.3g, inverted elements %d\n",
                        number(result["energy"]), number(result["gradient_norm"]),
                        result["inverted"].get<int>()));
  if (result["error_estimate"].is_number() && result["energy_scale"].is_number()) {
    PetscCall(PetscPrintf(comm, "estimated relative energy error %.1e%s\n",
                          number(result["error_estimate"]) / number(result["energy_scale"]),
                          result["minimum"].is_boolean() && result["minimum"].get<bool>()
                              ? ", at a minimum: the Hessian is positive definite"
                              : ""));
  }
  PetscCall(PetscPrintf(comm, "%s", text_of_error_table(result["error_table"]).c_str()));
  PetscCall(PetscPrintf(comm, "seconds %.3g:", number(time["total"])));
  for (const char *phase : {"read", "setup", "guess", "assembly", "filter", "linear_solve",
                            "line_search", "output", "other"}) {
    PetscCall(PetscPrintf(comm, " %s %.3g", phase, number(time[phase])));
  }
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
