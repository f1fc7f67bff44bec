#pragma once

#include <string>
#include <vector>

#include "input/option_table.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// The table of a scene's options, part by part; each row points into the options given here.
std::vector<OptionRow> mesh_rows(SceneOptions &options);
std::vector<OptionRow> region_rows(RegionOptions &region);  ///< without its material's
std::vector<OptionRow> constraint_rows(ConstraintOptions &constraint);
std::vector<OptionRow> gravity_rows(LoadsOptions &loads);
std::vector<OptionRow> load_rows(LoadOptions &load);
std::vector<OptionRow> solve_rows(SceneOptions &options);
std::vector<OptionRow> output_rows(SceneOptions &options);
std::vector<OptionRow> time_rows(TimeOptions &time);
std::vector<OptionRow> checkpoint_rows(CheckpointOptions &checkpoint);
std::vector<OptionRow> probe_rows(ProbeOptions &probe);
/// Read here as well, though they are the solver's, who lists them.
std::vector<OptionRow> solver_rows(SceneOptions &options);

/// The names of a scene's parts, before what is said of each.
OptionRow names_row(const std::string &list, std::vector<std::string> &names);

}  // namespace trefoil
