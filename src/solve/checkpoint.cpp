#include "solve/checkpoint.hpp"

#include <petsctime.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <initializer_list>

#include "scene/initial_displacement.hpp"
#include "solve/scene_changes.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// What ranks agree on; the larger wins.
enum Wish { nothing = 0, write = 1, write_and_stop = 2 };

volatile std::sig_atomic_t wish_of_signal = nothing;
bool is_stopped = false;
struct sigaction former_terminate, former_user;

/// A second SIGTERM ends the run at once.
void listen(int signal) {
  if (signal == SIGTERM) {
    wish_of_signal = write_and_stop;
    sigaction(SIGTERM, &former_terminate, nullptr);
  } else if (wish_of_signal == nothing) {
    wish_of_signal = write;
  }
}

/// Keeps an error's sentence instead of raising it.
PetscErrorCode keep_sentence(MPI_Comm, int, const char *, const char *, PetscErrorCode code,
                             PetscErrorType type, const char *message, void *sentence) {
  if (type == PETSC_ERROR_INITIAL && message) *static_cast<std::string *>(sentence) = message;
  return code;
}

/// The kinds of ways that cannot go on from each other's checkpoints.
const char *kind_of(const Scene &scene) {
  return scene.motion ? "time" : "load_steps";
}

}  // namespace

bool was_stopped() {
  return is_stopped;
}

Checkpoint::Checkpoint(Scene &scene) : scene_(scene), files_(scene.mesh) {}

Checkpoint::~Checkpoint() {
  if (!listens_) return;
  sigaction(SIGTERM, &former_terminate, nullptr);
  sigaction(SIGUSR1, &former_user, nullptr);
}

MPI_Comm Checkpoint::comm() const {
  return PetscObjectComm(reinterpret_cast<PetscObject>(scene_.mesh.dm));
}

bool Checkpoint::is_on() const {
  return !scene_.options.checkpoint.file.empty();
}

PetscErrorCode Checkpoint::open() {
  const CheckpointOptions &options = scene_.options.checkpoint;
  PetscFunctionBeginUser;
  if (!options.restart_file.empty()) {
    start_.emplace();
    PetscCall(files_.read(options.restart_file, &*start_));
    PetscCall(check_kind());
    PetscCall(warn_of_changes());
  }
  if (!is_on()) PetscFunctionReturn(PETSC_SUCCESS);
  struct sigaction action {};
  action.sa_handler = listen;
  action.sa_flags = SA_RESTART;
  sigaction(SIGTERM, &action, &former_terminate);
  sigaction(SIGUSR1, &action, &former_user);
  listens_ = true;
  last_ = MPI_Wtime();
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Checkpoint::check_kind() const {
  const std::string here = kind_of(scene_), there = start_->numbers.value("kind", "");
  PetscFunctionBeginUser;
  PetscCheck(here == there, comm(), PETSC_ERR_USER_INPUT,
             "%s is of a run %s, and this scene is %s: -restart goes on with the scene that wrote "
             "the file",
             scene_.options.checkpoint.restart_file.c_str(),
             there == "time" ? "in time" : "without time",
             here == "time" ? "one in time" : "one without time");
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// A run goes on with what it is given, and says where that is not what the file's run had.
PetscErrorCode Checkpoint::warn_of_changes() {
  std::map<std::string, std::string> there;
  PetscFunctionBeginUser;
  if (!start_->numbers.contains("scene")) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(take([&](const Json &numbers) { numbers.at("scene").get_to(there); }));
  const std::string changes = differences(there, options_of_energy(scene_.options.given));
  if (!changes.empty()) {
    scene_.warnings.push_back("the run goes on from one of another scene, " +
                              scene_.options.checkpoint.restart_file + ": " + changes);
    PetscCall(PetscPrintf(comm(), "WARNING: %s\n", scene_.warnings.back().c_str()));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What the first rank's clock, the count and the signals of any rank ask for.
PetscErrorCode Checkpoint::wish(bool counts, int *wish) {
  const CheckpointOptions &options = scene_.options.checkpoint;
  PetscMPIInt rank = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm(), &rank));
  *wish = static_cast<int>(wish_of_signal);
  if (counts) {
    ++passes_;
    const bool is_late =
        rank == 0 && options.interval() > 0 && MPI_Wtime() - last_ >= options.interval();
    const bool is_due = options.every > 0 && passes_ % options.every == 0;
    if (is_late || is_due) *wish = std::max<int>(*wish, write);
  }
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, wish, 1, MPI_INT, MPI_MAX, comm()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Checkpoint::pass(bool counts, const Part &solve) {
  int agreed = nothing;
  PetscFunctionBeginUser;
  if (!is_on()) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(wish(counts, &agreed));
  if (agreed == nothing) PetscFunctionReturn(PETSC_SUCCESS);
  if (wish_of_signal == write) wish_of_signal = nothing;
  PetscCall(save(solve));
  if (agreed < write_and_stop) PetscFunctionReturn(PETSC_SUCCESS);
  is_stopped = true;
  PetscCheck(!has_failed_, comm(), PETSC_ERR_SIG,
             "stopped by SIGTERM, and no checkpoint could be written of where it was");
  SETERRQ(comm(), PETSC_ERR_SIG, "stopped by SIGTERM; -restart %s goes on from here",
          scene_.options.checkpoint.file.c_str());
}

PetscErrorCode Checkpoint::save(const Part &solve) {
  SavedRun run;
  std::string sentence;
  PetscFunctionBeginUser;
  if (!is_on()) PetscFunctionReturn(PETSC_SUCCESS);
  run.numbers["kind"] = kind_of(scene_);
  run.numbers["scene"] = options_of_energy(scene_.options.given);
  run.numbers["way"] = options_of_way(scene_.options.given);
  for (const Part *part : std::initializer_list<const Part *>{&results_, &way_, &solve}) {
    if (*part) PetscCall((*part)(&run));
  }
  PetscCall(PetscPushErrorHandler(keep_sentence, &sentence));
  const PetscErrorCode outcome = files_.write(scene_.options.checkpoint.file, run);
  PetscCall(PetscPopErrorHandler());
  last_ = MPI_Wtime();
  const bool is_news = outcome && !has_failed_;
  has_failed_ = outcome != PETSC_SUCCESS;
  if (!is_news) PetscFunctionReturn(PETSC_SUCCESS);
  const bool has_former = std::ifstream(scene_.options.checkpoint.file).good();
  scene_.warnings.push_back(std::string("a checkpoint was not written") +
                            (has_former ? ", the one before stays: " : ": ") + sentence);
  PetscCall(PetscPrintf(comm(), "WARNING: %s\n", scene_.warnings.back().c_str()));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// How the options of the way differ from those of the file's run, as the end of a sentence.
std::string Checkpoint::changes_of_way() const {
  const std::map<std::string, std::string> there =
      start_->numbers.value("way", std::map<std::string, std::string>());
  const std::string changes = differences(there, options_of_way(scene_.options.given));
  return changes.empty() ? "" : "; " + changes;
}

PetscErrorCode Checkpoint::take(const std::function<void(const Json &numbers)> &read) const {
  bool fits = true;
  PetscFunctionBeginUser;
  try {
    read(start_->numbers);
  } catch (const Json::exception &) {
    fits = false;
  }
  PetscCheck(fits, comm(), PETSC_ERR_USER_INPUT,
             "%s lacks numbers that this scene goes on from: -restart goes on with the scene that "
             "wrote the file%s",
             scene_.options.checkpoint.restart_file.c_str(), changes_of_way().c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Checkpoint::keep(Vec x, const std::string &name, bool is_change,
                                SavedRun *run) const {
  const Discretization &discretization = scene_.discretization;
  Vec local = nullptr;
  const PetscScalar *values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(is_change ? discretization.get_local_direction(x, &local, &values)
                      : discretization.get_local(x, &local, &values));
  run->fields[name].assign(values, values + scene_.mesh.coordinates.size());
  PetscCall(discretization.restore_local(&local, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Checkpoint::fetch(const std::string &name, std::vector<double> *values) const {
  const auto found = start_->fields.find(name);
  PetscFunctionBeginUser;
  PetscCheck(found != start_->fields.end(), comm(), PETSC_ERR_USER_INPUT,
             "%s lacks the field '%s' that this scene goes on from: -restart goes on with the "
             "scene that wrote the file%s",
             scene_.options.checkpoint.restart_file.c_str(), name.c_str(),
             changes_of_way().c_str());
  *values = found->second;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Checkpoint::fetch(const std::string &name, Vec x) const {
  std::vector<double> values;
  PetscFunctionBeginUser;
  PetscCall(fetch(name, &values));
  PetscCall(set_unknowns(std::move(values), scene_.discretization, x));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
