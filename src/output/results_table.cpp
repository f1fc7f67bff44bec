#include "output/results_table.hpp"

#include <cstdio>

#include "support/petsc_compatibility.hpp"
#include "support/text_file.hpp"

namespace trefoil {
namespace {

/// One row, cell by cell.
class Row {
 public:
  void add(const std::string &cell) { text_ += (text_.empty() ? "" : ",") + cell; }
  void add(double value) {
    char cell[32];
    std::snprintf(cell, sizeof cell, "%.17g", value);
    add(std::string(cell));
  }
  template <class Vector>
  void add_vector(const Vector &vector) {
    for (const double component : vector) add(component);
  }
  void add_names(const std::string &name) {
    for (const char *axis : {"_x", "_y", "_z"}) add(name + axis);
  }
  [[nodiscard]] std::string line() const { return text_ + "\n"; }

 private:
  std::string text_;
};

std::string line_of_names(const RunReport &report) {
  Row names;
  for (const char *name : {"t", "energy", "strain_energy", "load_work", "iterations",
                           "largest_displacement", "least_det_F", "largest_von_mises", "volume"}) {
    names.add(std::string(name));
  }
  for (const ConstraintReport &constraint : report.constraints) {
    names.add_names(constraint.name + "_reaction");
    names.add_names(constraint.name + "_moment");
  }
  for (const LoadReport &load : report.loads) names.add_names(load.name + "_force");
  const StateReport &first = report.states.empty() ? report.end : report.states.front();
  for (const ProbeReport &probe : first.probes) names.add_names(probe.name + "_displacement");
  if (first.motion) {
    names.add(std::string("dt"));
    names.add(std::string("kinetic_energy"));
    names.add_names("momentum");
    names.add_names("angular_momentum");
  }
  if (first.contact) {
    for (const ObstacleReport &obstacle : first.contact->obstacles) {
      names.add_names(obstacle.name + "_contact_force");
    }
  }
  return names.line();
}

std::string line_of(const StateReport &state) {
  Row row;
  for (const double value :
       {state.t, state.energy, state.strain_energy, state.load_work,
        static_cast<double>(state.iterations), state.largest_displacement.value,
        state.least_determinant.value, state.largest_von_mises.value, state.volume}) {
    row.add(value);
  }
  for (const Resultant &reaction : state.reactions) {
    row.add_vector(reaction.force);
    row.add_vector(reaction.moment);
  }
  for (const Resultant &load : state.loads) row.add_vector(load.force);
  for (const ProbeReport &probe : state.probes) row.add_vector(probe.displacement);
  if (state.motion) {
    row.add(state.motion->step);
    row.add(state.motion->kinetic_energy);
    row.add_vector(state.motion->momentum);
    row.add_vector(state.motion->angular_momentum);
  }
  if (state.contact) {
    for (const ObstacleReport &obstacle : state.contact->obstacles) row.add_vector(obstacle.force);
  }
  return row.line();
}

}  // namespace

std::string results_table(const RunReport &report) {
  std::string table = line_of_names(report);
  for (const StateReport &state : report.states) {
    if (!state.is_loose) table += line_of(state);
  }
  return table;
}

PetscErrorCode ResultsFile::add(const RunReport &report) {
  const StateReport &state = report.states.back();
  int grows = !is_stream(path_);
  PetscFunctionBeginUser;
  if (path_.empty() || state.is_loose) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Bcast(&grows, 1, MPI_INT, 0, comm_));  // the first rank's stdout may be the file
  if (!grows) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(is_begun_ ? append_text_file(comm_, path_, line_of(state))
                      : write_text_file(comm_, path_, results_table(report)));
  is_begun_ = true;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode ResultsFile::end(const RunReport &report) {
  PetscFunctionBeginUser;
  if (path_.empty() || is_begun_) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(write_text_file(comm_, path_, results_table(report)));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
