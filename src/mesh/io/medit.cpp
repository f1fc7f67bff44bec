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

// "tetrahedron 7 names vertex 9"
[[noreturn]] void fail_for_vertex(const MeshFile &file, const CellList &mesh, std::size_t entry,
                                  std::int64_t vertex, std::int64_t vertices) {
  const std::size_t cell = 1 + entry / static_cast<std::size_t>(mesh.corners());
  file.fail_as_a_whole(mesh.shape->singular + std::string(" ") + std::to_string(cell) +
                       " names vertex " + std::to_string(vertex) +
                       ", but vertices are numbered from 1" +
                       (vertices > 0 ? " to " + std::to_string(vertices) : "") +
                       "; correct it or save the mesh again");
}

int read_dimension(MeshFile &file) {
  const std::int64_t dimension = file.integer("the dimension");
  if (dimension != 2 && dimension != 3)
    file.fail("the mesh has dimension " + std::to_string(dimension) +
              ", which is neither 2 nor 3; correct it");
  return static_cast<int>(dimension);
}

void read_vertices(MeshFile &file, int dimension, std::vector<double> &coordinates) {
  const std::int64_t count = file.integer("the number of vertices");
  file.check_room(count, bytes_of_plane_vertex, "vertices");
  file.check_numbering(count, 3, "vertices");
  coordinates.assign(static_cast<std::size_t>(3 * count), 0);
  for (std::size_t entry = 0; entry < coordinates.size(); entry += 3) {
    for (std::size_t component = 0; component < static_cast<std::size_t>(dimension); ++component) {
      const double coordinate = file.real("a vertex coordinate");
      if (!std::isfinite(coordinate))
        file.fail("vertex " + std::to_string(1 + entry / 3) +
                  " has a coordinate that is not finite; correct it");
      coordinates[entry + component] = coordinate;
    }
    file.integer("the reference of a vertex");
  }
}

// Tetrahedra or triangles, as mesh.dimension() says.
void read_cells(MeshFile &file, CellList &mesh) {
  const bool flat = mesh.dimension() == 2;
  const char *names = flat ? "triangles" : "tetrahedra";
  const std::int64_t count =
      file.integer(flat ? "the number of triangles" : "the number of tetrahedra");
  file.check_room(count, 2 * static_cast<std::size_t>(mesh.corners() + 1), names);
  file.check_numbering(count, mesh.corners(), names);
  mesh.cells.resize(static_cast<std::size_t>(mesh.corners() * count));
  for (std::size_t entry = 0; entry < mesh.cells.size();) {
    for (int corner = 0; corner < mesh.corners(); ++corner, ++entry) {
      const std::int64_t vertex =
          file.integer(flat ? "a vertex of a triangle" : "a vertex of a tetrahedron");
      if (vertex < 1 || vertex > std::numeric_limits<PetscInt>::max())
        fail_for_vertex(file, mesh, entry, vertex, 0);
      mesh.cells[entry] = static_cast<PetscInt>(vertex - 1);
    }
    file.integer(flat ? "the reference of a triangle" : "the reference of a tetrahedron");
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

void check_vertices_of_cells(const MeshFile &file, const CellList &mesh) {
  const PetscInt vertices = mesh.vertices();
  for (std::size_t entry = 0; entry < mesh.cells.size(); ++entry)
    if (mesh.cells[entry] >= vertices)
      fail_for_vertex(file, mesh, entry, std::int64_t{1} + mesh.cells[entry], vertices);
}

// Which sections were seen.
struct Seen {
  bool dimension = false, vertices = false, triangles = false, tetrahedra = false;
};

void mark_first(const MeshFile &file, bool &seen, std::string_view section) {
  if (seen)
    file.fail("a second section " + std::string(section) + "; keep one of the two in the file");
  seen = true;
}

void check_complete(const MeshFile &file, const Seen &seen, const CellList &mesh) {
  if (!seen.vertices || mesh.coordinates.empty())
    file.fail_as_a_whole("has no Vertices; save the mesh again");
  if (mesh.cells.empty())
    file.fail_as_a_whole(
        "has no Tetrahedra and no Triangles; save a volume mesh, or a plane one of triangles");
}

}  // namespace

CellList read_medit(MeshFile &file) {
  file.treat_as_comment('#');
  file.expect_word("MeshVersionFormatted");
  file.integer("the version of the format");

  CellList mesh, triangles;
  triangles.shape = &shapes::tri3;
  int dimension = 0;
  Seen seen;
  for (std::string section(file.next_word());
       !section.empty() && section != "End" && section != "END"; section = file.next_word()) {
    if (!names_section(section))
      file.fail("found " + quoted(section) +
                " where the name of a section should be, so a count does not match what follows "
                "it; save the mesh again");
    if (section == "Dimension") {
      mark_first(file, seen.dimension, section);
      dimension = read_dimension(file);
    } else if (section == "Vertices") {
      mark_first(file, seen.vertices, section);
      if (!seen.dimension) file.fail("Vertices come before Dimension; add the line 'Dimension 3'");
      read_vertices(file, dimension, mesh.coordinates);
    } else if (section == "Tetrahedra") {
      mark_first(file, seen.tetrahedra, section);
      read_cells(file, mesh);
    } else if (section == "Triangles") {
      mark_first(file, seen.triangles, section);
      read_cells(file, triangles);
    } else if (names_other_volume_cells(section)) {
      refuse_other_volume_cells(file, section);
    } else {
      skip_section(file);
    }
  }
  if (mesh.cells.empty()) {
    triangles.coordinates.swap(mesh.coordinates);
    mesh = std::move(triangles);
  }
  check_complete(file, seen, mesh);
  check_vertices_of_cells(file, mesh);
  return mesh;
}

}  // namespace trefoil
