#include "mesh/io/read_mesh.hpp"

#include "mesh/io/gmsh.hpp"
#include "mesh/io/medit.hpp"
#include "mesh/io/mesh_file.hpp"

namespace trefoil {
namespace {

// A binary Medit file begins with the integer 1, in the byte order of who wrote it.
bool is_binary_medit(const MeshFile &file) {
  using namespace std::string_view_literals;
  return file.rest().starts_with("\1\0\0\0"sv) || file.rest().starts_with("\0\0\0\1"sv);
}

}  // namespace

CellList read_mesh(const std::string &path) {
  MeshFile file(path);
  if (is_binary_medit(file))
    file.fail_as_a_whole("is a binary Medit file (.meshb), which is not read; save it as ASCII");
  if (file.peek_word().starts_with('$')) return read_gmsh(file);

  file.treat_as_comment('#');
  if (file.peek_word() == "MeshVersionFormatted") return read_medit(file);
  file.fail_as_a_whole(
      "is not in a format that is read, which are Medit .mesh (ASCII) and Gmsh .msh 2.2 and 4.1; "
      "convert the mesh to one of them");
}

}  // namespace trefoil
