#include <cstdio>

#include "output/record.hpp"

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

}  // namespace

std::string results_table(const RunReport &report) {
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
  for (const ProbeReport &probe : report.end.probes) names.add_names(probe.name + "_displacement");
  const bool moves = !report.states.empty() && report.states.front().motion;
  if (moves) {
    names.add(std::string("dt"));
    names.add(std::string("kinetic_energy"));
    names.add_names("momentum");
    names.add_names("angular_momentum");
  }
  std::string table = names.line();
  for (const StateReport &state : report.states) {
    if (state.is_loose) continue;
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
    if (moves) {
      row.add(state.motion->step);
      row.add(state.motion->kinetic_energy);
      row.add_vector(state.motion->momentum);
      row.add_vector(state.motion->angular_momentum);
    }
    table += row.line();
  }
  return table;
}

}  // namespace trefoil
