#include <algorithm>
#include <string>
#include <utility>

#include "mesh/io/gmsh.hpp"

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

// "4 triangles of first order"
std::string text_of(const GmshElements &elements) {
  return counted(static_cast<long long>(elements.tags.size()), *elements.shape) + " of " +
         (is_quadratic(*elements.shape) ? "second" : "first") + " order";
}

// The elements that make the body: those of the highest dimension.
GmshElements &body(const MeshFile &file, GmshContents &contents) {
  GmshElements *found = nullptr;
  for (GmshElements &each : contents.elements) {
    if (each.tags.empty() || each.shape->dimension < 2) continue;
    if (found && found->shape->dimension == each.shape->dimension)
      file.fail_as_a_whole("has " + text_of(*found) + " beside " + text_of(each) +
                           "; save it again with all of one order (gmsh -order 2)");
    found = &each;
  }
  std::string others;
  for (const auto &[type, count] : contents.other_types) {
    if (dimension_of_element(type) != (found ? found->shape->dimension : 2)) continue;
    others += (others.empty() ? "" : " and ") + name_of_elements(type) + " (" +
              std::to_string(count) + ")";
  }
  if (found && others.empty()) return *found;
  if (found)
    file.fail_as_a_whole("has " + others + " beside " + text_of(*found) + ", but only " +
                         found->shape->plural +
                         " are read; mesh it with these alone (without Recombine)");
  file.fail_as_a_whole("has no tetrahedra (element type 4 or 11) and no triangles in $Elements" +
                       (others.empty()
                            ? "; mesh the volume (gmsh -3) and save all of it"
                            : ", but " + others + "; mesh it with triangles or tetrahedra"));
}

// Appends the vertices of an element's first `nodes` nodes, in our order.
void append_vertices(const MeshFile &file, const VertexOfTag &vertex_of_tag,
                     const GmshElements &elements, std::size_t element, std::size_t nodes,
                     std::vector<PetscInt> &vertices) {
  const auto width = static_cast<std::size_t>(elements.shape->nodes);
  for (std::size_t k = 0; k < nodes; ++k) {
    const auto place = static_cast<std::size_t>(elements.shape->gmsh_order[k]);
    const std::int64_t tag = elements.nodes[width * element + place];
    const PetscInt vertex = vertex_of_tag(tag);
    if (vertex == no_vertex)
      file.fail_as_a_whole("element " + std::to_string(elements.tags[element]) + " names node " +
                           std::to_string(tag) +
                           ", which $Nodes does not define; correct it or save the mesh again");
    vertices.push_back(vertex);
  }
}

// What the groups have of points, curves and, in a volume mesh, surfaces.
void take_groups_below(const MeshFile &file, const VertexOfTag &vertex_of_tag,
                       const GmshContents &contents, CellList &mesh) {
  for (const GmshElements &elements : contents.elements) {
    if (elements.shape->dimension >= mesh.dimension()) continue;
    const auto corners = static_cast<std::size_t>(elements.shape->corners);
    auto &entities = mesh.groups.below[static_cast<std::size_t>(elements.shape->dimension)];
    for (std::size_t e = 0; e < elements.tags.size(); ++e) {
      if (elements.sets[e] == 0) continue;
      append_vertices(file, vertex_of_tag, elements, e, corners, entities.vertices);
      entities.sets.push_back(elements.sets[e]);
    }
  }
}

}  // namespace

GmshElements *GmshContents::place_for(std::int64_t type, PetscInt set) {
  for (GmshElements &each : elements)
    if (each.shape->gmsh_type == type)
      return each.shape->dimension < 2 && set == 0 ? nullptr : &each;
  ++other_types[type];
  return nullptr;
}

CellList mesh_of(const MeshFile &file, GmshContents contents) {
  CellList mesh;
  const GmshElements &cells = body(file, contents);
  mesh.shape = cells.shape;
  const auto width = static_cast<std::size_t>(mesh.nodes_per_cell());
  file.check_numbering(static_cast<std::int64_t>(contents.node_tags.size()), 3, "nodes");
  file.check_numbering(static_cast<std::int64_t>(cells.tags.size()), mesh.nodes_per_cell(),
                       mesh.shape->plural);
  mesh.coordinates = std::move(contents.coordinates);
  mesh.groups = std::move(contents.groups);
  const VertexOfTag vertex_of_tag(file, contents.node_tags);
  mesh.cells.reserve(cells.nodes.size());
  for (std::size_t cell = 0; cell < cells.tags.size(); ++cell)
    append_vertices(file, vertex_of_tag, cells, cell, width, mesh.cells);
  if (std::any_of(cells.sets.begin(), cells.sets.end(), [](PetscInt set) { return set != 0; }))
    mesh.groups.set_of_cell = cells.sets;
  take_groups_below(file, vertex_of_tag, contents, mesh);
  return mesh;
}

}  // namespace trefoil
