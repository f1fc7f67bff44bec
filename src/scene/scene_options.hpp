#pragma once

#include <petscsys.h>

#include <string>
#include <vector>

#include "scene/load_options.hpp"
#include "scene/material_options.hpp"
#include "scene/region_options.hpp"

namespace trefoil {

/// Part of a boundary condition: which vertices, and where they go.
struct ConstraintOptions {
  std::string name;
  std::string where;  ///< expression, non-zero at the vertices it takes
  std::string move;   ///< expression with a value for each dimension, or `free`; empty: zero
};

/// A scene as the user describes it, see read_scene_options() for the names of the options.
struct SceneOptions {
  std::string mesh_file, generate;
  PetscInt resolution = 0, refine = 0;
  bool normalize = false;
  std::string repair = "none", partitioner = "metis";
  MaterialOptions material;
  std::vector<RegionOptions> regions;
  LoadOptions loads;
  PetscInt load_steps = 1;
  std::vector<ConstraintOptions> constraints;
  std::string initial = "auto";
  std::string initial_displacement;  ///< expression with three values, for initial `expression`
  PetscInt initial_steps = 20;       ///< local/global steps of arap
  PetscInt order = 0;  ///< of the elements; 0: as the mesh has it, which generated ones have linear
  std::string filter_space = "element";  ///< -snes_trefoil_space, which the element term reads
  std::string assembly = "split";        ///< or "hook": through the plugin's watch on the Mat
  std::string output_file;
  std::string record_file;  ///< -snes_trefoil_record; the program completes and writes it
};

/// Reads the scene from PETSc's options. Misspelt names and values out of range are errors with one
/// sentence on all ranks. For -help it prints them, and whether they make a scene is not asked.
/// Collective.
PetscErrorCode read_scene_options(MPI_Comm comm, SceneOptions *options);

}  // namespace trefoil
