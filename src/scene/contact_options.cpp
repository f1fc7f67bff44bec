#include "scene/contact_options.hpp"

#include <charconv>

#include "scene/scene_option_rows.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode is_given(const std::vector<OptionRow> &rows, bool *any) {
  PetscFunctionBeginUser;
  for (const OptionRow &row : rows) {
    PetscBool given = PETSC_FALSE;
    PetscCall(PetscOptionsHasName(nullptr, nullptr, ("-" + row.name).c_str(), &given));
    *any = *any || given;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool is_positive_number(const std::string &text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && value > 0;
}

PetscErrorCode check_obstacle(MPI_Comm comm, const ObstacleOptions &obstacle) {
  const char *name = obstacle.name.c_str();
  PetscFunctionBeginUser;
  PetscCheck(obstacle.plane.empty() != obstacle.file.empty(), comm, PETSC_ERR_USER_INPUT,
             "obstacle '%s' needs either -obstacle_%s_plane, the outward normal of a half-space, "
             "or -obstacle_%s_file, an .obj or .stl",
             name, name, name);
  PetscCheck(obstacle.at.empty() || obstacle.file.empty(), comm, PETSC_ERR_USER_INPUT,
             "-obstacle_%s_at is for half-spaces; move a surface by -obstacle_%s_move", name, name);
  PetscCheck(obstacle.friction.value_or(0) >= 0, comm, PETSC_ERR_USER_INPUT,
             "-obstacle_%s_friction is %g and must not be negative", name, *obstacle.friction);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_contact(MPI_Comm comm, const ContactOptions &contact) {
  PetscFunctionBeginUser;
  PetscCheck(contact.distance > 0 && contact.distance < 1, comm, PETSC_ERR_USER_INPUT,
             "-contact_distance is %g; it is a share of the box's diagonal, above 0 and below 1",
             contact.distance);
  PetscCheck(contact.stiffness == "auto" || is_positive_number(contact.stiffness), comm,
             PETSC_ERR_USER_INPUT,
             "-contact_stiffness is %s; give a number above 0, force per area, or auto",
             contact.stiffness.c_str());
  PetscCheck(contact.friction >= 0, comm, PETSC_ERR_USER_INPUT,
             "-contact_friction is %g and must not be negative", contact.friction);
  PetscCheck(contact.friction_iterations >= -1, comm, PETSC_ERR_USER_INPUT,
             "-contact_friction_iterations is %" PetscInt_FMT
             "; give a number from 1 on, 0: until little of it lags, or -1: until it fits",
             contact.friction_iterations);
  PetscCheck(contact.slip_velocity > 0, comm, PETSC_ERR_USER_INPUT,
             "-contact_slip_velocity is %g and must be above 0", contact.slip_velocity);
  PetscCheck(contact.ccd > 0 && contact.ccd < 1, comm, PETSC_ERR_USER_INPUT,
             "-contact_ccd is %g; it is the share of a gap that a step may use up, above 0 and "
             "below 1",
             contact.ccd);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::vector<OptionRow> contact_rows(ContactOptions &contact) {
  return {
      {"contact_distance", &contact.distance, "Below which bodies push each other away",
       "share of the diagonal of the bodies' box"},
      {"contact_stiffness", &contact.stiffness,
       "Of the barrier; auto: a tenth of the softer body's Young's modulus", "force per area"},
      {"contact_friction", &contact.friction, "Coefficient of friction"},
      {"contact_friction_iterations", &contact.friction_iterations,
       "Solves a step, each with the contact forces of the last; 0: until less than 5 % of "
       "friction lags, 5 at most, and one in time; -1: until they fit, 20 at most"},
      {"contact_slip_velocity", &contact.slip_velocity, "Below which friction sticks",
       "share of the diagonal per unit of time"},
      {"contact_self", &contact.self, "Whether a body meets itself"},
      {"contact_ccd", &contact.ccd, "Share of a gap that one step may use up"},
      {"contact_weight",
       &contact.weight,
       "What filters contact: clamp, or what filters the elements",
       "",
       {"clamp", "rule"}},
      {"contact_iterates", &contact.iterates,
       "Every iterate for ParaView, .xdmf; for small meshes"},
  };
}

std::vector<OptionRow> obstacle_rows(ObstacleOptions &obstacle) {
  const std::string option = "obstacle_" + obstacle.name;
  return {
      {option + "_plane", &obstacle.plane, "Half-space: its outward normal", "", {}, true},
      {option + "_at", &obstacle.at, "A point of its face; the origin without", "length"},
      {option + "_file", &obstacle.file, "Instead: a surface, .obj or .stl"},
      {option + "_move", &obstacle.move, "Displacement in x y z t; 0 without", "length"},
      {option + "_friction", &obstacle.friction,
       "Coefficient of friction, where not -contact_friction"},
  };
}

PetscErrorCode read_contact(MPI_Comm comm, OptionReader &reader, ContactOptions *contact) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(is_given(contact_rows(*contact), &contact->is_on));
  PetscCall(reader.read(contact_rows(*contact)));
  PetscCall(reader.read(names_row("obstacles", names)));
  for (const std::string &name : names) {
    ObstacleOptions obstacle{name};
    PetscCall(reader.read(obstacle_rows(obstacle)));
    PetscCall(check_obstacle(comm, obstacle));
    contact->obstacles.push_back(obstacle);
    contact->is_on = true;
  }
  PetscCall(check_contact(comm, *contact));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
