#pragma once

#include <petscsys.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "scene/body_options.hpp"
#include "scene/contact_options.hpp"
#include "scene/material_options.hpp"
#include "scene/time_options.hpp"

namespace trefoil {

/// Part of a boundary condition: which vertices, and where they go.
struct ConstraintOptions {
  std::string name;
  std::string where = {};  ///< formula, non-zero at the vertices it takes
  std::string group = {};  ///< name or number of a group of the mesh file
  std::string move = {};   ///< expression with a value for each dimension, or `free`; empty: zero
  std::string slide = {};  ///< instead: normal of the planes in which the vertices slide
};

/// A part of the body with a material of its own: the cells where an expression holds, or those of
/// one of the mesh file's groups.
struct RegionOptions {
  std::string name;
  std::string where = {};  ///< expression, non-zero at the rest centroids of its cells; or
  std::string group = {};  ///< name or number of a physical group of the mesh file
  MaterialOptions material = {};
};

/// A load on a part of the surface. All formulas may depend on t.
struct LoadOptions {
  std::string name;
  std::string where = {};     ///< formula, non-zero at all corners of the facets it takes
  std::string group = {};     ///< name or number of a group of the mesh file
  std::string traction = {};  ///< formula with a value for each dimension: force per rest area
  std::string force = {};     ///< the same: the whole force, which is spread by area
  std::string pressure =
      {};  ///< formula with one value, positive into the body: force per rest area

  bool follower = false;       ///< the pressure acts on the current area
  std::string spring = {};     ///< formula with one value: stiffness per rest area
  bool spring_normal = false;  ///< the springs hold along the normal only

  [[nodiscard]] bool pulls() const {
    return !traction.empty() || !force.empty() || !pressure.empty() || !spring.empty();
  }
};

/// A place whose displacement is asked for.
struct ProbeOptions {
  std::string name;
  std::string place = {};  ///< formula with a value for each dimension, at rest
};

/// What a run leaves behind so that another can go on from there.
struct CheckpointOptions {
  std::string file;               ///< empty: none
  PetscInt every = 0;             ///< iterations, in time steps; 0: by time alone
  std::optional<double> seconds;  ///< from one to the next; 0: never
  std::string restart_file;       ///< goes on from there; empty: begins at the beginning

  static constexpr double usual_seconds = 60;
  /// Between two checkpoints; 0: time does not count.
  [[nodiscard]] double interval() const { return seconds.value_or(every > 0 ? 0 : usual_seconds); }
};

/// What pulls at the body.
struct LoadsOptions {
  std::string gravity = {};  ///< formula with a value for each dimension: acceleration; empty: none
  std::vector<LoadOptions> loads = {};
  bool is_in_time = false;  ///< t of the formulas is time: nothing is scaled by it
};

/// A scene as the user describes it, see scene_option_groups() for the names of the options.
struct SceneOptions {
  std::string mesh_file, generate;      ///< one of them, or
  std::vector<std::string> mesh_files;  ///< several, or
  std::vector<BodySource> bodies;       ///< several that are named; those of mesh_files too
  std::string mesh_write;               ///< write the mesh to this file, in HDF5, and solve nothing
  PetscInt resolution = 0, refine = 0;
  bool normalize = false;
  std::string repair = "none", partitioner = "metis";
  PetscInt order = 0;  ///< of the elements; 0: as the mesh has it, which generated ones have linear
  std::string element_pressure = "auto";  ///< or pointwise, constant; chosen with the mesh
  MaterialOptions material;
  std::vector<RegionOptions> regions;
  bool is_all_regions = false;  ///< no cell has `material`; known with the mesh
  std::vector<ConstraintOptions> constraints;
  LoadsOptions loads;
  ContactOptions contact;
  double where_tolerance = 1e-9;  ///< of every `where`: ==, <= and >= hold within, box diagonals
  std::string load_steps = "1";   ///< a number, or auto
  double first_load_step = 0.25;  ///< length of the first one, of `auto`
  double least_load_step = 1. / 1024;  ///< below which none is halved
  std::string initial = "auto";
  std::string initial_displacement;  ///< expression, for initial `expression`
  std::string initial_file;          ///< with a displacement, for initial `file`
  PetscInt initial_steps = 20;       ///< local/global steps of arap
  TimeOptions time;
  std::string filter_space = "element";  ///< -snes_trefoil_space, which the element term reads
  std::string solver = "auto";           ///< of linear systems: or "direct", "iterative"
  std::string assembly = "split";        ///< or "hook": through the plugin's watch on the Mat
  bool check = false;                    ///< build the scene, say what it holds, solve nothing
  std::string output_file;
  std::vector<std::string> output_fields;  ///< empty: see default_fields()
  PetscInt output_every = 1;               ///< of a series: each so many states, and the last
  std::string csv_file;                    ///< results as a table
  double progress_seconds = 5;             ///< between lines about long work; 0: none
  CheckpointOptions checkpoint;
  std::vector<ProbeOptions> probes;
  std::string record_file;  ///< -snes_trefoil_record; the program completes and writes it
  std::map<std::string, std::string> given;  ///< options of a scene that were given, by name
  std::vector<std::string> scene_files;      ///< what the program has read: not to be written over
};

/// Reads the scene from PETSc's options. Misspelt names and values out of range are errors with one
/// sentence on all ranks. Collective.
PetscErrorCode read_scene_options(MPI_Comm comm, SceneOptions *options);

/// How many equal steps the loads come in; 0: auto.
PetscInt number_of_load_steps(const SceneOptions &options);

/// Whether a scene has several states, one after the other.
bool has_series(const SceneOptions &options);

/// All options of a scene, with their defaults; those of its named parts as of a part called NAME.
std::vector<OptionGroup> scene_option_groups();

}  // namespace trefoil
