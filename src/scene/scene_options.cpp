#include "scene/scene_options.hpp"

#include <petscpartitioner.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <utility>

#include "output/snapshot.hpp"
#include "scene/obstacle_output.hpp"
#include "scene/scene_option_rows.hpp"
#include "scene/unknown_options.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

PetscErrorCode read_regions(MPI_Comm comm, OptionReader &reader, SceneOptions *options) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.read(names_row("regions", names)));
  for (const std::string &name : names) {
    const std::string option = "region_" + name;
    RegionOptions region{name, "", "", options->material};
    PetscCall(reader.read(region_rows(region)));
    PetscCheck(region.where.empty() != region.group.empty(), comm, PETSC_ERR_USER_INPUT,
               "region '%s' needs either -%s_where or -%s_group: say which cells it takes",
               name.c_str(), option.c_str(), option.c_str());
    PetscCall(read_material(comm, reader, option + "_material", &region.material));
    options->regions.push_back(region);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_constraints(MPI_Comm comm, OptionReader &reader, SceneOptions *options) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.read(names_row("constraints", names)));
  for (const std::string &name : names) {
    ConstraintOptions constraint{name};
    PetscCall(reader.read(constraint_rows(constraint)));
    PetscCheck(
        !constraint.where.empty() || !constraint.group.empty(), comm, PETSC_ERR_USER_INPUT,
        "constraint '%s' has neither -constraint_%s_where nor -constraint_%s_group: say which "
        "vertices it takes",
        name.c_str(), name.c_str(), name.c_str());
    PetscCheck(constraint.slide.empty() || constraint.move.empty(), comm, PETSC_ERR_USER_INPUT,
               "constraint '%s' has both -constraint_%s_move and -constraint_%s_slide; give one",
               name.c_str(), name.c_str(), name.c_str());
    options->constraints.push_back(constraint);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_probes(MPI_Comm comm, OptionReader &reader, SceneOptions *options) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.read(names_row("probes", names)));
  for (const std::string &name : names) {
    ProbeOptions probe{name};
    PetscCall(reader.read(probe_rows(probe)));
    PetscCheck(!probe.place.empty(), comm, PETSC_ERR_USER_INPUT,
               "probe '%s' has no place: say where, -probe_%s \"0, 0, 1\"", name.c_str(),
               name.c_str());
    options->probes.push_back(probe);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_loads(MPI_Comm comm, OptionReader &reader, LoadsOptions *loads) {
  std::vector<std::string> names;
  PetscFunctionBeginUser;
  PetscCall(reader.read(gravity_rows(*loads)));
  PetscCall(reader.read(names_row("loads", names)));
  for (const std::string &name : names) {
    PetscCheck(name != "gravity" && name != "steps", comm, PETSC_ERR_USER_INPUT,
               "'%s' is no name for a load: -load_%s is an option of its own, in a scene file "
               "load: {%s: ...}",
               name.c_str(), name.c_str(), name.c_str());
    LoadOptions load{name};
    PetscCall(reader.read(load_rows(load)));
    const char *of = name.c_str();
    PetscCheck((!load.where.empty() || !load.group.empty()) && load.pulls(), comm,
               PETSC_ERR_USER_INPUT,
               "load '%s' needs -load_%s_where or -load_%s_group, and one of -load_%s_traction, "
               "-load_%s_force, -load_%s_pressure, -load_%s_spring: say which facets it takes and "
               "how it pulls at them",
               of, of, of, of, of, of, of);
    PetscCheck(!load.follower || !load.pressure.empty(), comm, PETSC_ERR_USER_INPUT,
               "-load_%s_follower is for a pressure: give -load_%s_pressure as well", of, of);
    PetscCheck(!load.spring_normal || !load.spring.empty(), comm, PETSC_ERR_USER_INPUT,
               "-load_%s_spring_normal is for springs: give -load_%s_spring as well", of, of);
    loads->loads.push_back(load);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode read_time(MPI_Comm comm, OptionReader &reader, TimeOptions *time) {
  PetscFunctionBeginUser;
  for (const OptionRow &row : time_rows(*time)) {
    PetscBool given = PETSC_FALSE;
    PetscCall(PetscOptionsHasName(nullptr, nullptr, ("-" + row.name).c_str(), &given));
    time->is_on = time->is_on || given;
    PetscCall(reader.read(row));
  }
  if (time->is_on) PetscCall(check_time(comm, *time));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Checked here and not only where a mesh is partitioned, which on one rank none is.
PetscErrorCode check_partitioner(MPI_Comm comm, const std::string &name) {
  PetscErrorCode (*create)(PetscPartitioner) = nullptr;
  PetscFunctionBeginUser;
  if (name == "metis") PetscFunctionReturn(PETSC_SUCCESS);
  PetscCall(PetscPartitionerInitializePackage());
  PetscCall(PetscFunctionListFind(PetscPartitionerList, name.c_str(), &create));
  PetscCheck(create, comm, PETSC_ERR_USER_INPUT,
             "there is no partitioner '%s' (-mesh_partitioner); use metis or ptscotch",
             name.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

bool is_same_file(const std::string &one, const std::string &other) {
  const auto normal = [](const std::string &path) {
    std::error_code ignored;
    const auto whole = std::filesystem::weakly_canonical(std::filesystem::absolute(path), ignored);
    return ignored ? std::filesystem::path(path) : whole;
  };
  return !one.empty() && !other.empty() && normal(one) == normal(other);
}

/// No file is written over another that is read or written.
PetscErrorCode check_files(MPI_Comm comm, const SceneOptions &options) {
  PetscFunctionBeginUser;
  std::vector<std::string> taken = options.scene_files;
  taken.push_back(options.mesh_file);
  for (const BodySource &body : options.bodies) taken.push_back(body.file);
  taken.push_back(options.initial_file);
  std::vector<std::pair<std::string, std::string>> written{
      {"mesh_write", options.mesh_write},
      {"output_csv", options.csv_file},
      {"snes_trefoil_record", options.record_file},
      {"checkpoint", options.checkpoint.file}};
  if (!options.contact.iterates.empty()) {
    for (const std::string &file : files_of_output(options.contact.iterates)) {
      written.emplace_back("contact_iterates", file);
    }
  }
  if (!options.output_file.empty()) {
    const std::vector<std::string> files = files_of_output(options.output_file);
    for (auto file = files.rbegin(); file != files.rend(); ++file) {
      written.insert(written.begin(), {"output_file", *file});
    }
    for (const ObstacleOptions &obstacle : options.contact.obstacles) {
      for (const std::string &file :
           files_of_output(output_of_obstacle(options.output_file, obstacle.name))) {
        written.emplace_back("output_file", file);
      }
    }
  }
  for (const auto &[option, file] : written) {
    for (const std::string &other : taken) {
      PetscCheck(!is_same_file(file, other), comm, PETSC_ERR_USER_INPUT,
                 "-%s would write over '%s'; give it another name", option.c_str(), other.c_str());
    }
    taken.push_back(file);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_start(MPI_Comm comm, const SceneOptions &options) {
  PetscFunctionBeginUser;
  PetscCheck((options.initial == "expression") == !options.initial_displacement.empty(), comm,
             PETSC_ERR_USER_INPUT,
             options.initial == "expression"
                 ? "-initial expression needs -initial_displacement: three expressions"
                 : "-initial_displacement is for -initial expression");
  PetscCheck((options.initial == "file") == !options.initial_file.empty(), comm,
             PETSC_ERR_USER_INPUT,
             options.initial == "file"
                 ? "-initial file needs -initial_file: what Trefoil has written, or a checkpoint"
                 : "-initial_file is for -initial file");
  PetscCheck(options.initial_steps >= 0, comm, PETSC_ERR_USER_INPUT,
             "-initial_steps must not be negative");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_checkpoint(MPI_Comm comm, const SceneOptions &options) {
  const CheckpointOptions &checkpoint = options.checkpoint;
  PetscFunctionBeginUser;
  PetscCheck(checkpoint.every >= 0 && checkpoint.seconds.value_or(0) >= 0, comm,
             PETSC_ERR_USER_INPUT,
             "-checkpoint_every (%" PetscInt_FMT
             ") and -checkpoint_seconds (%g) must not be "
             "negative",
             checkpoint.every, checkpoint.seconds.value_or(0));
  PetscCheck(!checkpoint.file.empty() || (checkpoint.every == 0 && !checkpoint.seconds), comm,
             PETSC_ERR_USER_INPUT,
             "-checkpoint_every and -checkpoint_seconds say when; say where as well, -checkpoint "
             "run.ckpt");
  PetscCheck(checkpoint.restart_file.empty() || options.initial != "file", comm,
             PETSC_ERR_USER_INPUT,
             "-restart and -initial file both say what to start from; -restart goes on with a run, "
             "-initial file begins another one: give one");
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode check_values(MPI_Comm comm, const SceneOptions &options) {
  PetscFunctionBeginUser;
  const int sources =
      !options.mesh_file.empty() + !options.generate.empty() + !options.bodies.empty();
  PetscCheck(sources > 0, comm, PETSC_ERR_USER_INPUT,
             "there is no mesh: give -mesh_file, -mesh_generate, or several bodies by -mesh_files "
             "or -bodies");
  PetscCheck(sources == 1, comm, PETSC_ERR_USER_INPUT,
             "a scene has one mesh: give one of -mesh_file, -mesh_generate, -mesh_files, -bodies");
  PetscCall(check_partitioner(comm, options.partitioner));
  PetscCheck(options.refine >= 0 && options.resolution >= 0, comm, PETSC_ERR_USER_INPUT,
             "-mesh_refine and -mesh_resolution must not be negative");
  PetscCheck(options.resolution == 0 || !options.generate.empty(), comm, PETSC_ERR_USER_INPUT,
             "-mesh_resolution is for -mesh_generate; use -mesh_refine for a mesh from a file, and "
             "-body_NAME_resolution for a body that is generated");
  PetscCheck(options.order >= 0 && options.order <= 2, comm, PETSC_ERR_USER_INPUT,
             "-order is %" PetscInt_FMT
             "; elements are linear (1), quadratic (2), or as the mesh has them (0)",
             options.order);
  PetscCheck(options.load_steps == "auto" || number_of_load_steps(options) > 0, comm,
             PETSC_ERR_USER_INPUT, "-load_steps is %s; give a whole number from 1 on, or auto",
             options.load_steps.c_str());
  PetscCheck(options.first_load_step > 0 && options.first_load_step <= 1 &&
                 options.least_load_step > 0 && options.least_load_step <= 1,
             comm, PETSC_ERR_USER_INPUT,
             "-load_steps_first (%g) and -load_steps_least (%g) must lie above 0 and not above 1",
             options.first_load_step, options.least_load_step);
  PetscCheck(options.where_tolerance >= 0 && options.where_tolerance < 1, comm,
             PETSC_ERR_USER_INPUT,
             "-where_tolerance is %g; it is a share of the box's diagonal, from 0 to 1",
             options.where_tolerance);
  PetscCheck(options.output_every >= 1, comm, PETSC_ERR_USER_INPUT,
             "-output_every is %" PetscInt_FMT "; give a whole number from 1 on",
             options.output_every);
  PetscCheck(options.progress_seconds >= 0, comm, PETSC_ERR_USER_INPUT,
             "-progress_seconds is %g; give seconds between two lines, or 0 for none",
             options.progress_seconds);
  PetscCheck(options.output_every == 1 || has_series(options), comm, PETSC_ERR_USER_INPUT,
             "-output_every is for steps: with one solve there is one state");
  PetscCheck(options.output_every == 1 || !options.output_file.empty(), comm, PETSC_ERR_USER_INPUT,
             "-output_every is for -output_file, which is not given; a table by -output_csv has a "
             "row for each state");
  PetscCall(check_start(comm, options));
  PetscCall(check_checkpoint(comm, options));
  PetscCall(check_files(comm, options));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscInt number_of_load_steps(const SceneOptions &options) {
  const std::string &text = options.load_steps;
  int count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  return error == std::errc{} && end == text.data() + text.size() ? count : 0;
}

bool has_series(const SceneOptions &options) {
  return options.time.is_on || number_of_load_steps(options) != 1;
}

PetscErrorCode read_scene_options(MPI_Comm comm, SceneOptions *options) {
  OptionReader reader(comm);
  PetscFunctionBeginUser;
  PetscCall(reader.read(mesh_rows(*options)));
  PetscCall(read_bodies(comm, reader, options->mesh_files, &options->bodies));
  PetscCall(read_material(comm, reader, "material", &options->material));
  PetscCall(read_regions(comm, reader, options));
  PetscCall(read_constraints(comm, reader, options));
  PetscCall(read_loads(comm, reader, &options->loads));
  PetscCall(read_contact(comm, reader, &options->contact));
  PetscCall(reader.read(solve_rows(*options)));
  PetscCall(read_time(comm, reader, &options->time));
  options->loads.is_in_time = options->time.is_on;
  PetscCall(reader.read(output_rows(*options)));
  PetscCall(reader.read(checkpoint_rows(options->checkpoint)));
  PetscCall(read_probes(comm, reader, options));
  PetscCall(reader.read(solver_rows(*options)));
  PetscCall(refuse_unknown(comm, reader.known()));
  PetscCall(check_values(comm, *options));
  options->given = reader.given();
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
