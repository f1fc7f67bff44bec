#include "scene/body_options.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "scene/scene_option_rows.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"
#include "trefoil/input_error.hpp"

namespace trefoil {
namespace {

/// Numbers between commas; throws InputError where there are not as many as one of `counts`.
std::vector<double> numbers_of(const std::string &text, const std::string &option,
                               std::initializer_list<std::size_t> counts, const char *wanted) {
  std::string list = text;
  std::replace(list.begin(), list.end(), ',', ' ');
  std::istringstream words(list);
  std::vector<double> numbers;
  for (double number = 0; words >> number;) numbers.push_back(number);
  const bool is_finite = std::all_of(numbers.begin(), numbers.end(),
                                     [](double number) { return std::isfinite(number); });
  if (!words.eof() || !is_finite ||
      std::find(counts.begin(), counts.end(), numbers.size()) == counts.end()) {
    throw InputError(option + " is '" + text + "'; give " + wanted);
  }
  return numbers;
}

/// Throws InputError.
Placement placement_of(const BodyOptions &body) {
  const std::string option = "-body_" + body.name;
  Placement placement;
  if (!(body.scale > 0)) {
    throw InputError(option + "_scale must be above 0");
  }
  placement.scale = body.scale;
  if (!body.translate.empty()) {
    const auto shift = numbers_of(body.translate, option + "_translate", {2, 3},
                                  "a number for each dimension, \"0, 0, 1.1\"");
    std::copy(shift.begin(), shift.end(), placement.shift.begin());
  }
  if (!body.rotate.empty()) {
    const auto turn = numbers_of(body.rotate, option + "_rotate", {1, 4},
                                 "degrees about z, or an axis and degrees, \"0, 1, 0, 30\"");
    if (turn.size() == 4) std::copy_n(turn.begin(), 3, placement.axis.begin());
    placement.degrees = turn.back();
    if (!(std::hypot(placement.axis[0], placement.axis[1], placement.axis[2]) > 0)) {
      throw InputError(option + "_rotate has no axis: its length is 0");
    }
  }
  return placement;
}

PetscErrorCode check_body(MPI_Comm comm, const BodyOptions &body) {
  const char *name = body.name.c_str();
  PetscFunctionBeginUser;
  PetscCheck(body.file.empty() != body.generate.empty(), comm, PETSC_ERR_USER_INPUT,
             "body '%s' needs either -body_%s_file or -body_%s_generate: say where it comes from",
             name, name, name);
  PetscCheck(body.resolution >= 0 && (body.resolution == 0 || body.file.empty()), comm,
             PETSC_ERR_USER_INPUT,
             "-body_%s_resolution is for a generated body, a whole number from 0 on", name);
  PetscCheck(body.name.find('/') == std::string::npos, comm, PETSC_ERR_USER_INPUT,
             "'%s' is no name for a body: it has a slash, which parts a body from its groups",
             name);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

std::vector<OptionRow> body_rows(BodyOptions &body) {
  const std::string option = "body_" + body.name;
  return {
      {option + "_file", &body.file, "One of several bodies: Medit .mesh, Gmsh .msh 2.2 or 4.1"},
      {option + "_generate",
       &body.generate,
       "Instead: made here",
       "",
       {"knot", "box", "cylinder", "ball", "square"}},
      {option + "_resolution", &body.resolution, "As mesh_resolution"},
      {option + "_scale", &body.scale, "First it is scaled about the origin,"},
      {option + "_rotate", &body.rotate,
       "then turned about it: about z, or an axis and an angle, \"0, 1, 0, 30\"", "degrees"},
      {option + "_translate", &body.translate, "then moved", "length"},
  };
}

PetscErrorCode read_bodies(MPI_Comm comm, OptionReader &reader,
                           const std::vector<std::string> &files, std::vector<BodySource> *bodies) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.read(names_row("bodies", names)));
  PetscCheck(files.empty() || names.empty(), comm, PETSC_ERR_USER_INPUT,
             "a scene has its bodies from -mesh_files or from -bodies, not from both");
  for (const std::string &file : files) {
    const std::string name = std::filesystem::path(file).stem().string();
    const bool is_taken = std::any_of(bodies->begin(), bodies->end(),
                                      [&](const BodySource &other) { return other.name == name; });
    PetscCheck(!is_taken, comm, PETSC_ERR_USER_INPUT,
               "-mesh_files has two files called '%s'; name the bodies yourself, bodies: {one: "
               "{file: ...}, another: {file: ...}}",
               name.c_str());
    bodies->push_back({.name = name, .file = file});
  }
  for (const std::string &name : names) {
    BodyOptions body{name};
    BodySource source;
    PetscCall(reader.read(body_rows(body)));
    PetscCall(check_body(comm, body));
    const std::string complaint = complaint_of([&] {
      source = {name, body.file, body.generate, body.resolution, placement_of(body)};
    });
    PetscCall(agree_on_complaint(comm, complaint));
    bodies->push_back(source);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
