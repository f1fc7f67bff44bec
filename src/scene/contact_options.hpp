#pragma once

#include <optional>
#include <string>
#include <vector>

#include "input/option_table.hpp"

namespace trefoil {

/// What bodies cannot enter.
struct ObstacleOptions {
  std::string name;
  std::string plane = {}, at = {};  ///< a half-space: its outward normal, a point of its face; or
  std::string file = {};            ///< a surface
  std::string move = {};            ///< formula with a value for each dimension; empty: at rest
  std::optional<double> friction = {};
};

/// How bodies and obstacles keep each other out.
struct ContactOptions {
  bool is_on = false;  ///< any option of contact or of obstacles is given
  double distance = 1e-3;
  std::string stiffness = "auto";
  double friction = 0;
  PetscInt friction_iterations = 0;
  double slip_velocity = 1e-3;
  bool self = true;
  double ccd = 0.9;
  std::string weight = "clamp";
  std::string iterates;
  std::vector<ObstacleOptions> obstacles;
};

std::vector<OptionRow> contact_rows(ContactOptions &contact);
std::vector<OptionRow> obstacle_rows(ObstacleOptions &obstacle);
/// Reads them. Collective; values out of range are errors with one sentence on all ranks.
PetscErrorCode read_contact(MPI_Comm comm, OptionReader &reader, ContactOptions *contact);

}  // namespace trefoil
