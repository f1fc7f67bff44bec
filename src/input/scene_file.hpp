#pragma once

#include <map>
#include <string>
#include <vector>

namespace trefoil {

/// Reads scene files, in YAML, into words of a command line: `mesh: {file: a.msh}` becomes
/// `-mesh_file a.msh`. Mappings are joined by underscores, lists of names and numbers by commas,
/// `<<` merges, and what stands under a key that begins with $$ is left to anchors, as in PETSc's
/// own options files.
///
/// Parts with names may be written once: `constraints: {wall: {group: wall}}` becomes
/// `-constraint_wall_group wall -constraints wall`; likewise regions, loads, probes, obstacles,
/// bodies. Several files add up their names.
class SceneFileReader {
 public:
  /// The words, in the order of the file; values that look like options have a blank in front.
  /// @throws InputError with the file's name, the line, and the way out
  std::vector<std::string> read(const std::string &path);

 private:
  std::map<std::string, std::vector<std::string>> names_;  ///< of each list, of all files so far
};

}  // namespace trefoil
