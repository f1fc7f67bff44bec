#include "solve/state_log.hpp"

#include "output/saved_states.hpp"
#include "scene/state_report.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {

StateLog::StateLog(Scene &scene, RunReport *report)
    : scene_(scene),
      report_(*report),
      states_(report->states),
      output_(scene, has_series(scene.options)),
      table_(PetscObjectComm(reinterpret_cast<PetscObject>(scene.mesh.dm)),
             scene.options.csv_file) {}

PetscErrorCode StateLog::observe(double t, PetscInt iterations, bool is_loose) {
  const double start = MPI_Wtime();
  const auto every = static_cast<std::size_t>(scene_.options.output_every);
  StateReport state;
  PetscFunctionBeginUser;
  state.iterations = iterations;
  state.is_loose = is_loose;
  PetscCall(describe_state(scene_, t, &state));
  is_written_ = !is_loose && states_.size() % every == 0;
  if (is_written_) PetscCall(output_.write(t));
  states_.push_back(state);
  PetscCall(table_.add(report_));
  seconds_ += MPI_Wtime() - start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateLog::close(double t, StateReport *end) {
  const double start = MPI_Wtime();
  // Nothing converged: the last iterate, or the body at rest.
  const bool has_none = states_.empty() || states_.back().is_loose;
  PetscFunctionBeginUser;
  if (has_none) {
    PetscCall(describe_state(scene_, t, end));
  } else {
    *end = states_.back();
  }
  if (has_none || !is_written_) PetscCall(output_.write(has_none ? t : end->t));
  seconds_ += MPI_Wtime() - start;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode StateLog::end_table() {
  PetscFunctionBeginUser;
  PetscCall(table_.end(report_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void StateLog::save(SavedRun *run) const {
  auto states = Checkpoint::Json::array();
  for (const StateReport &state : states_) states.push_back(trefoil::save(state));
  run->numbers["states"] = states;
  run->numbers["is_written"] = is_written_;
  run->numbers["output"] = output_.save();
}

PetscErrorCode StateLog::go_on(const Checkpoint &checkpoint) {
  Checkpoint::Json output;
  bool fits = true;
  PetscFunctionBeginUser;
  PetscCall(checkpoint.take([&](const Checkpoint::Json &numbers) {
    for (const auto &state : numbers.at("states")) states_.push_back(load_state(state));
    is_written_ = numbers.at("is_written");
    output = numbers.at("output");
  }));
  for (const StateReport &state : states_) {
    fits = fits && state.reactions.size() == scene_.constraints.reports().size() &&
           state.loads.size() == scene_.load_reports.size();
  }
  PetscCheck(fits, PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm)),
             PETSC_ERR_USER_INPUT,
             "%s is of a run with other constraints or loads: -restart goes on with the scene that "
             "wrote the file",
             scene_.options.checkpoint.restart_file.c_str());
  PetscCall(output_.go_on(output));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
