#include "mesh/io/gmsh.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace trefoil {
namespace {

constexpr PetscInt no_vertex = -1;

// Finds the vertex of a node tag. Tags are mostly numbered from 1 without gaps, so a table does;
// where they are scattered, a sorted list takes its place.
class VertexOfTag {
 public:
  VertexOfTag(const MeshFile &file, const std::vector<std::int64_t> &tags) {
    const auto [lowest, highest] = std::minmax_element(tags.begin(), tags.end());
    first_tag_ = *lowest;
    const std::uint64_t span = offset_of(*highest);
    is_dense_ = span < 4 * tags.size() + 1024;
    if (is_dense_)
      fill_table(file, tags, span + 1);
    else
      fill_sorted_list(file, tags);
  }

  // no_vertex if the file does not define the node.
  PetscInt operator()(std::int64_t tag) const {
    if (is_dense_) {
      const std::uint64_t offset = offset_of(tag);
      return offset < table_.size() ? table_[offset] : no_vertex;
    }
    const auto found =
        std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{tag, PetscInt{0}});
    return found != sorted_.end() && found->first == tag ? found->second : no_vertex;
  }

 private:
  // Unsigned, so that no tag overflows and tags below the first become huge.
  [[nodiscard]] std::uint64_t offset_of(std::int64_t tag) const {
    return static_cast<std::uint64_t>(tag) - static_cast<std::uint64_t>(first_tag_);
  }

  void fill_table(const MeshFile &file, const std::vector<std::int64_t> &tags, std::size_t size) {
    table_.assign(size, no_vertex);
    PetscInt vertex = 0;
    for (const std::int64_t tag : tags) {
      PetscInt &entry = table_[offset_of(tag)];
      if (entry != no_vertex) fail_for_repeated(file, tag);
      entry = vertex++;
    }
  }

  void fill_sorted_list(const MeshFile &file, const std::vector<std::int64_t> &tags) {
    sorted_.reserve(tags.size());
    for (const std::int64_t tag : tags)
      sorted_.emplace_back(tag, static_cast<PetscInt>(sorted_.size()));
    std::sort(sorted_.begin(), sorted_.end());
    for (std::size_t entry = 1; entry < sorted_.size(); ++entry)
      if (sorted_[entry].first == sorted_[entry - 1].first)
        fail_for_repeated(file, sorted_[entry].first);
  }

  [[noreturn]] static void fail_for_repeated(const MeshFile &file, std::int64_t tag) {
    file.fail_as_a_whole("defines node " + std::to_string(tag) + " twice; save the mesh again");
  }

  bool is_dense_ = false;
  std::int64_t first_tag_ = 0;
  std::vector<PetscInt> table_;
  std::vector<std::pair<std::int64_t, PetscInt>> sorted_;
};

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

void read_section(GmshNumbers &numbers, Version version, const std::string &section,
                  GmshContents &contents) {
  const bool is_nodes = section == "$Nodes";
  const bool has_cells = std::any_of(contents.cells.begin(), contents.cells.end(),
                                     [](const GmshCells &cells) { return !cells.tags.empty(); });
  if (is_nodes ? !contents.node_tags.empty() : has_cells)
    numbers.file().fail("a second section " + section + "; save the mesh as one file, once");
  if (numbers.is_binary()) numbers.file().end_line();
  if (version == Version::v2_2)
    is_nodes ? read_nodes_2_2(numbers, contents) : read_elements_2_2(numbers, contents);
  else
    is_nodes ? read_nodes_4_1(numbers, contents) : read_elements_4_1(numbers, contents);
  numbers.file().expect_word("$End" + section.substr(1));
}

void read_groups(GmshNumbers &numbers, const std::string &section, GmshGroups &groups) {
  if (section == "$PhysicalNames") {
    read_physical_names(numbers.file(), groups);
  } else {
    if (numbers.is_binary()) numbers.file().end_line();
    read_entities_4_1(numbers, groups);
  }
  numbers.file().expect_word("$End" + section.substr(1));
}

GmshContents read_sections(MeshFile &file, const Format &format) {
  GmshContents contents;
  GmshNumbers numbers(file, format.is_binary);
  for (std::string section(file.next_word()); !section.empty(); section = file.next_word()) {
    if (section.front() != '$' || section.size() < 2)
      file.fail("found " + quoted(section) +
                " where a section should begin with $; save the mesh again");
    if (section == "$Nodes" || section == "$Elements")
      read_section(numbers, format.version, section, contents);
    else if (section == "$PhysicalNames" ||
             (section == "$Entities" && format.version == Version::v4_1))
      read_groups(numbers, section, contents.groups);
    else
      skip_section(file, section);
  }
  return contents;
}

// The cells that make the body: those of the highest dimension.
GmshCells &body(const MeshFile &file, GmshContents &contents) {
  GmshCells *found = nullptr;
  for (GmshCells &each : contents.cells) {
    if (each.tags.empty()) continue;
    if (found && found->shape->dimension == each.shape->dimension)
      file.fail_as_a_whole("has " +
                           counted(static_cast<long long>(found->tags.size()), *found->shape) +
                           " of first order beside " + std::to_string(each.tags.size()) +
                           " of second; save it again with all of one order (gmsh -order 2)");
    found = &each;
  }
  if (found) return *found;
  file.fail_as_a_whole(
      "has no tetrahedra (element type 4 or 11) and no triangles in $Elements; mesh the volume "
      "(gmsh -3) and save all of it");
}

// Groups of the cells, where any has one, and the names of such groups.
void number_groups(const GmshCells &cells, const GmshGroups &groups, CellList &mesh) {
  if (std::any_of(cells.groups.begin(), cells.groups.end(),
                  [](std::int64_t group) { return group != 0; }))
    mesh.groups.assign(cells.groups.begin(), cells.groups.end());
  for (const auto &[name, number] : groups.of_dimension[cells.shape->dimension])
    mesh.group_names.emplace(name, static_cast<PetscInt>(number));
}

CellList number_vertices(const MeshFile &file, GmshContents contents) {
  CellList mesh;
  const GmshCells &cells = body(file, contents);
  mesh.shape = cells.shape;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  file.check_numbering(static_cast<std::int64_t>(contents.node_tags.size()), 3, "nodes");
  file.check_numbering(static_cast<std::int64_t>(cells.tags.size()), mesh.nodes_per_cell(),
                       mesh.shape->plural);
  mesh.coordinates = std::move(contents.coordinates);
  mesh.cells.resize(cells.nodes.size());
  std::vector<std::size_t> place(width);  // in our order, of each node in theirs
  for (std::size_t k = 0; k < width; ++k)
    place[static_cast<std::size_t>(mesh.shape->gmsh_order[k])] = k;
  const VertexOfTag vertex_of_tag(file, contents.node_tags);
  for (std::size_t entry = 0; entry < cells.nodes.size(); ++entry) {
    const PetscInt vertex = vertex_of_tag(cells.nodes[entry]);
    if (vertex == no_vertex)
      file.fail_as_a_whole("element " + std::to_string(cells.tags[entry / width]) + " names node " +
                           std::to_string(cells.nodes[entry]) +
                           ", which $Nodes does not define; correct it or save the mesh again");
    mesh.cells[entry - entry % width + place[entry % width]] = vertex;
  }
  number_groups(cells, contents.groups, mesh);
  return mesh;
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
  return number_vertices(file, std::move(contents));
}

}  // namespace trefoil
