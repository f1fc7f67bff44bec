#include "mesh/io/medit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace trefoil {
namespace {

// An item of k numbers takes at least k digits and k blanks.
constexpr std::size_t bytes_of_plane_vertex = 2 * 3;

bool names_section(std::string_view word) {
  const char first = word.empty() ? '\0' : word.front();
  return (first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z');
}

bool names_other_volume_cells(std::string_view section) {
  constexpr std::array<std::string_view, 11> others = {
      "Hexahedra",    "Hexaedra",     "Prisms",   "Pentahedra",  "Pyramids",  "Wedges",
      "TetrahedraP2", "TetrahedraP3", "PrismsP2", "HexahedraQ2", "PyramidsP2"};
  return std::find(others.begin(), others.end(), section) != others.end();
}

bool names_other_plane_cells(std::string_view section) {
  constexpr std::array<std::string_view, 5> others = {
      "Quadrilaterals", "QuadrilateralsQ2", "QuadrilateralsQ3", "TrianglesP2", "TrianglesP3"};
  return std::find(others.begin(), others.end(), section) != others.end();
}

// Entities of one shape: their vertices and references.
struct Section {
  const CellShape *shape;
  bool is_there = false;
  std::vector<PetscInt> vertices{}, references{};
};

// What the file says.
struct Contents {
  int dimension = 0;
  std::vector<double> coordinates;
  std::array<Section, 4> sections{{{&shapes::point},
                                   {&shapes::edge2},
                                   {&shapes::tri3},
                                   {&shapes::tet4}}};  ///< by the dimension of their shapes
  std::string other_plane_cells;                       ///< "Quadrilaterals (3)"

  [[nodiscard]] Section *section_called(const std::string &name) {
    const auto found = std::find_if(sections.begin(), sections.end(), [&](const Section &section) {
      return name == section.shape->medit;
    });
    return found == sections.end() ? nullptr : &*found;
  }
  /// The cells that make the body.
  [[nodiscard]] const Section &body() const {
    return sections[sections[3].vertices.empty() ? 2 : 3];
  }
};

// "tetrahedron 7 names vertex 9"
[[noreturn]] void fail_for_vertex(const MeshFile &file, const CellShape &shape, std::size_t entry,
                                  std::int64_t vertex, std::int64_t vertices) {
  const std::size_t number = 1 + entry / static_cast<std::size_t>(shape.corners);
  file.fail_as_a_whole(shape.singular + std::string(" ") + std::to_string(number) +
                       " names vertex " + std::to_string(vertex) +
                       ", but vertices are numbered from 1" +
                       (vertices > 0 ? " to " + std::to_string(vertices) : "") +
                       "; correct it or save the mesh again");
}

PetscInt read_reference(MeshFile &file, const char *what) {
  const std::int64_t reference = file.integer(what);
  if (std::abs(static_cast<double>(reference)) > std::numeric_limits<std::int32_t>::max())
    file.fail("found " + std::string(what) + " " + std::to_string(reference) +
              ", which is out of range; correct it or save the mesh again");
  return static_cast<PetscInt>(reference);
}

int read_dimension(MeshFile &file) {
  const std::int64_t dimension = file.integer("the dimension");
  if (dimension != 2 && dimension != 3)
    file.fail("the mesh has dimension " + std::to_string(dimension) +
              ", which is neither 2 nor 3; correct it");
  return static_cast<int>(dimension);
}

void read_vertices(MeshFile &file, Contents &contents) {
  if (contents.dimension == 0)
    file.fail("Vertices come before Dimension; add the line 'Dimension 3'");
  const std::int64_t count = file.integer("the number of vertices");
  file.check_room(count, bytes_of_plane_vertex, "vertices");
  file.check_numbering(count, 3, "vertices");
  contents.coordinates.assign(static_cast<std::size_t>(3 * count), 0);
  Section &vertices = contents.sections[0];
  for (std::size_t vertex = 0; vertex < static_cast<std::size_t>(count); ++vertex) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(contents.dimension); ++k) {
      const double coordinate = file.real("a vertex coordinate");
      if (!std::isfinite(coordinate))
        file.fail("vertex " + std::to_string(1 + vertex) +
                  " has a coordinate that is not finite; correct it");
      contents.coordinates[3 * vertex + k] = coordinate;
    }
    const PetscInt reference = read_reference(file, "the reference of a vertex");
    if (reference == 0) continue;
    vertices.vertices.push_back(static_cast<PetscInt>(vertex));
    vertices.references.push_back(reference);
  }
}

void read_entities(MeshFile &file, Section &section) {
  const CellShape &shape = *section.shape;
  const std::string one = shape.dimension == 1 ? "an edge" : "a " + std::string(shape.singular);
  const std::string number = "the number of " + std::string(shape.plural);
  const std::string vertex_name = "a vertex of " + one, reference = "the reference of " + one;
  const std::int64_t count = file.integer(number.c_str());
  file.check_room(count, 2 * static_cast<std::size_t>(shape.corners + 1), shape.plural);
  file.check_numbering(count, shape.corners, shape.plural);
  section.vertices.resize(static_cast<std::size_t>(shape.corners * count));
  section.references.resize(static_cast<std::size_t>(count));
  for (std::size_t entry = 0; entry < section.vertices.size();) {
    for (int corner = 0; corner < shape.corners; ++corner, ++entry) {
      const std::int64_t vertex = file.integer(vertex_name.c_str());
      if (vertex < 1 || vertex > std::numeric_limits<PetscInt>::max())
        fail_for_vertex(file, shape, entry, vertex, 0);
      section.vertices[entry] = static_cast<PetscInt>(vertex - 1);
    }
    section.references[entry / static_cast<std::size_t>(shape.corners) - 1] =
        read_reference(file, reference.c_str());
  }
}

// The numbers of a section that has nothing to say here, up to the next section's name.
void skip_section(MeshFile &file) {
  while (!file.peek_word().empty() && !names_section(file.peek_word())) file.next_word();
}

void refuse_other_volume_cells(MeshFile &file, const std::string &section) {
  if (file.integer("a number of cells") > 0)
    file.fail("the mesh has " + section +
              ", but only linear tetrahedra are read; save a mesh of first-order tetrahedra");
}

// They matter where it turns out that the body is plane.
void note_other_plane_cells(MeshFile &file, const std::string &section, Contents &contents) {
  const std::int64_t count = file.integer("a number of cells");
  if (count > 0 && contents.other_plane_cells.empty())
    contents.other_plane_cells = section + " (" + std::to_string(count) + ")";
  skip_section(file);
}

void mark_first(const MeshFile &file, bool &seen, const std::string &section) {
  if (seen) file.fail("a second section " + section + "; keep one of the two in the file");
  seen = true;
}

void read_section(MeshFile &file, const std::string &section, bool &has_dimension,
                  Contents &contents) {
  if (section == "Dimension") {
    mark_first(file, has_dimension, section);
    contents.dimension = read_dimension(file);
  } else if (Section *entities = contents.section_called(section)) {
    mark_first(file, entities->is_there, section);
    entities->shape->dimension == 0 ? read_vertices(file, contents)
                                    : read_entities(file, *entities);
  } else if (names_other_volume_cells(section)) {
    refuse_other_volume_cells(file, section);
  } else if (names_other_plane_cells(section)) {
    note_other_plane_cells(file, section, contents);
  } else {
    skip_section(file);
  }
}

void check_complete(const MeshFile &file, const Contents &contents) {
  if (contents.coordinates.empty()) file.fail_as_a_whole("has no Vertices; save the mesh again");
  const Section &body = contents.body();
  if (body.shape->dimension == 2 && !contents.other_plane_cells.empty())
    file.fail_as_a_whole("has " + contents.other_plane_cells +
                         (body.vertices.empty() ? "" : " beside Triangles") +
                         ", but only Triangles and Tetrahedra are read; mesh it with these alone");
  if (body.vertices.empty())
    file.fail_as_a_whole(
        "has no Tetrahedra and no Triangles; save a volume mesh, or a plane one of triangles");
}

// What the groups have of triangles, edges and vertices that are no cells.
void take_groups_below(const Contents &contents, CellList &mesh) {
  for (const Section &section : contents.sections) {
    if (section.shape->dimension >= mesh.dimension()) continue;
    const auto corners = static_cast<std::ptrdiff_t>(section.shape->corners);
    auto &entities = mesh.groups.below[static_cast<std::size_t>(section.shape->dimension)];
    auto vertex = section.vertices.begin();
    for (const PetscInt reference : section.references) {
      if (reference != 0) {
        entities.vertices.insert(entities.vertices.end(), vertex, vertex + corners);
        entities.sets.push_back(mesh.groups.set_of(section.shape->dimension, reference));
      }
      vertex += corners;
    }
  }
}

CellList mesh_of(const MeshFile &file, Contents contents) {
  CellList mesh;
  const Section &body = contents.body();
  mesh.shape = body.shape;
  mesh.coordinates = std::move(contents.coordinates);
  for (const Section &section : contents.sections)
    for (std::size_t entry = 0; entry < section.vertices.size(); ++entry)
      if (section.vertices[entry] >= mesh.vertices())
        fail_for_vertex(file, *section.shape, entry, std::int64_t{1} + section.vertices[entry],
                        mesh.vertices());
  mesh.cells = body.vertices;
  if (std::any_of(body.references.begin(), body.references.end(), [](PetscInt r) { return r; }))
    for (const PetscInt reference : body.references)
      mesh.groups.set_of_cell.push_back(mesh.groups.set_of(mesh.dimension(), reference));
  take_groups_below(contents, mesh);
  return mesh;
}

}  // namespace

CellList read_medit(MeshFile &file) {
  file.treat_as_comment('#');
  file.expect_word("MeshVersionFormatted");
  file.integer("the version of the format");
  Contents contents;
  bool has_dimension = false;
  for (std::string section(file.next_word());
       !section.empty() && section != "End" && section != "END"; section = file.next_word()) {
    if (!names_section(section))
      file.fail("found " + quoted(section) +
                " where the name of a section should be, so a count does not match what follows "
                "it; save the mesh again");
    read_section(file, section, has_dimension, contents);
  }
  check_complete(file, contents);
  return mesh_of(file, std::move(contents));
}

}  // namespace trefoil
