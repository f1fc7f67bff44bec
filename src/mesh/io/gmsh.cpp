#include "mesh/io/gmsh.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace trefoil {
namespace {

enum class Version { v2_2, v4_1 };

struct Format {
  Version version;
  bool is_binary;
};

Version read_version(MeshFile &file) {
  const std::string version(file.next_word());
  if (version == "2.2") return Version::v2_2;
  if (version == "4.1") return Version::v4_1;
  file.fail("the format is MSH version " + quoted(version) +
            ", but 2.2 and 4.1 are read; save it again with gmsh -format msh41");
}

// A binary file says the integer 1 once, so that its byte order shows.
void check_byte_order(MeshFile &file) {
  const auto one = file.binary<std::uint32_t>("the mark of the byte order");
  if (one == 0x01000000U)
    file.fail(
        "the file was written on a machine of the other byte order; save it as ASCII "
        "(Mesh.Binary = 0)");
  if (one != 1U) file.fail("the mark of the byte order is not 1; save the mesh again");
}

Format read_format(MeshFile &file) {
  const Version version = read_version(file);
  const std::int64_t file_type = file.integer("the file type");
  if (file_type != 0 && file_type != 1)
    file.fail("the file type is " + std::to_string(file_type) +
              ", but is 0 for ASCII and 1 for binary; save the mesh again");
  const std::int64_t data_size = file.integer("the data size");
  if (data_size != 8)
    file.fail("numbers have " + std::to_string(data_size) +
              " bytes, but only 8 are read; save it again with a 64-bit gmsh");
  if (file_type == 1) {
    file.end_line();
    file.treat_as_binary();
    check_byte_order(file);
  }
  file.expect_word("$EndMeshFormat");
  return {version, file_type == 1};
}

void skip_section(MeshFile &file, std::string_view section) {
  const std::string name(section.substr(1));
  if (!file.skip_past("$End" + name))
    file.fail("section $" + name + " has no end $End" + name +
              ", so the file is truncated; save the mesh again");
}

void read_nodes(GmshNumbers &numbers, Version version, bool is_parametric, GmshContents &contents) {
  if (!contents.node_tags.empty())
    numbers.file().fail("a second section of nodes; save the mesh as one file, once");
  if (version == Version::v2_2)
    read_nodes_2_2(numbers, is_parametric, contents);
  else
    read_nodes_4_1(numbers, contents);
}

void read_elements(GmshNumbers &numbers, Version version, GmshContents &contents) {
  if (std::any_of(contents.elements.begin(), contents.elements.end(),
                  [](const GmshElements &elements) { return !elements.tags.empty(); }))
    numbers.file().fail("a second section $Elements; save the mesh as one file, once");
  if (version == Version::v2_2)
    read_elements_2_2(numbers, contents);
  else
    read_elements_4_1(numbers, contents);
}

// False where the section has nothing to say here.
bool read_section(GmshNumbers &numbers, Version version, const std::string &section,
                  GmshContents &contents) {
  const bool has_entities = version == Version::v4_1;
  if (section == "$PhysicalNames") {
    read_physical_names(numbers.file(), contents);
    return true;
  }
  const bool is_parametric = section == "$ParametricNodes";
  const bool is_nodes = section == "$Nodes" || is_parametric, is_elements = section == "$Elements";
  const bool is_entities = has_entities && section == "$Entities";
  const bool is_partitioned = has_entities && section == "$PartitionedEntities";
  if (!is_nodes && !is_elements && !is_entities && !is_partitioned) return false;
  if (numbers.is_binary()) numbers.file().end_line();
  if (is_nodes) read_nodes(numbers, version, is_parametric, contents);
  if (is_elements) read_elements(numbers, version, contents);
  if (is_entities) read_entities_4_1(numbers, contents);
  if (is_partitioned) read_partitioned_entities_4_1(numbers, contents);
  return true;
}

GmshContents read_sections(MeshFile &file, const Format &format) {
  GmshContents contents;
  GmshNumbers numbers(file, format.is_binary);
  for (std::string section(file.next_word()); !section.empty(); section = file.next_word()) {
    if (section.front() != '$' || section.size() < 2)
      file.fail("found " + quoted(section) +
                " where a section should begin with $; save the mesh again");
    if (read_section(numbers, format.version, section, contents))
      file.expect_word("$End" + section.substr(1));
    else
      skip_section(file, section);
  }
  return contents;
}

}  // namespace

CellList read_gmsh(MeshFile &file) {
  std::string section(file.next_word());
  for (; section == "$Comments"; section = file.next_word()) skip_section(file, section);
  if (section == "$NOD")
    file.fail("the format is MSH version '1.0', but 2.2 and 4.1 are read; save it again with gmsh");
  if (section != "$MeshFormat")
    file.fail("found " + quoted(section) + " where $MeshFormat should be; save the mesh again");

  const Format format = read_format(file);
  GmshContents contents = read_sections(file, format);
  if (contents.node_tags.empty()) file.fail_as_a_whole("has no $Nodes; save the mesh again");
  return mesh_of(file, std::move(contents));
}

}  // namespace trefoil
