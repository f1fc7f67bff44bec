#include "mesh/io/read_mesh.hpp"

#include <filesystem>

#include "mesh/io/foreign_format.hpp"
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

// Whatever a Gmsh file begins with begins with a dollar sign, but so do Nastran's comments.
bool is_gmsh(MeshFile &file) {
  const std::string_view word = file.peek_word();
  if (word == "$MeshFormat" || word == "$Comments") return true;
  return word.starts_with('$') && !has_foreign_name(file.path());
}

// "convert body.meshb body.mesh"
std::string ascii_copy(const std::string &path) {
  const std::filesystem::path from(path);
  return "convert " + from.filename().string() + " " + from.stem().string() + ".mesh";
}

}  // namespace

CellList read_mesh(const std::string &path) {
  MeshFile file(path);
  const std::string_view beginning = file.rest();
  if (is_binary_medit(file))
    file.fail_as_a_whole("is a binary Medit file (.meshb), which is not read; convert it: meshio " +
                         ascii_copy(path) + ", or save it as ASCII");
  if (is_gmsh(file)) return read_gmsh(file);

  file.treat_as_comment('#');
  if (file.peek_word() == "MeshVersionFormatted") return read_medit(file);
  file.fail_as_a_whole(advice_on_format(path, beginning));
}

}  // namespace trefoil
