#include "mesh/io/foreign_format.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <vector>

namespace trefoil {
namespace {

enum class Content {
  mesh,      // that meshio can convert
  gmsh_too,  // and Gmsh as well
  surface,   // without a volume inside
  geometry   // that Gmsh can mesh
};

struct Format {
  const char *name;
  Content content;
  std::vector<std::string_view> endings;  // in lower case
  std::vector<std::string_view> marks;    // one of them begins the file; a tag of XML stands near
};

const std::vector<Format> &known_formats() {
  using namespace std::string_view_literals;
  static const std::vector<Format> formats = {
      {"a Fluent (ANSYS) mesh", Content::mesh, {}, {"(0 ", "(1 ", "(2 "}},
      {"a Nastran mesh",
       Content::gmsh_too,
       {".bdf", ".nas", ".fem"},
       {"SOL ", "CEND", "BEGIN BULK"}},
      {"an Abaqus or CalculiX mesh",
       Content::mesh,
       {".inp"},
       {"*HEADING", "*NODE", "*Heading", "*Node"}},
      {"a VTK file", Content::mesh, {".vtk"}, {"# vtk DataFile"}},
      {"a VTK file", Content::mesh, {".vtu", ".pvtu"}, {"<VTKFile"}},
      {"an XDMF file", Content::mesh, {".xdmf", ".xmf"}, {"<Xdmf"}},
      {"an Exodus file", Content::mesh, {".exo", ".e", ".ex2"}, {"CDF\1", "CDF\2"}},
      {"a MED file", Content::gmsh_too, {".med"}, {}},
      {"a CGNS file", Content::gmsh_too, {".cgns"}, {}},
      {"an HDF5 file", Content::mesh, {".h5", ".h5m"}, {"\x89HDF"sv}},
      {"an I-deas universal file", Content::gmsh_too, {".unv"}, {}},
      {"a TetGen mesh", Content::mesh, {".ele", ".node"}, {}},
      {"a Netgen mesh", Content::mesh, {".vol"}, {"mesh3d"}},
      {"an SU2 mesh", Content::gmsh_too, {".su2"}, {"NDIME"}},
      {"a UGRID mesh", Content::mesh, {".ugrid"}, {}},
      {"an ANSYS CDB file", Content::mesh, {".cdb"}, {"/COM,"}},
      {"a surface in STL", Content::surface, {".stl"}, {"solid "}},
      {"a surface in Wavefront OBJ", Content::surface, {".obj"}, {}},
      {"a surface in PLY", Content::surface, {".ply"}, {"ply\n", "ply\r"}},
      {"a surface in OFF", Content::surface, {".off"}, {"OFF"}},
      {"a geometry of Gmsh", Content::geometry, {".geo"}, {}},
      {"a geometry in STEP", Content::geometry, {".step", ".stp"}, {"ISO-10303-21"}},
      {"a geometry in IGES", Content::geometry, {".iges", ".igs"}, {}},
      {"a geometry in BREP",
       Content::geometry,
       {".brep"},
       {"DBRep_DrawableShape", "CASCADE Topology"}}};
  return formats;
}

std::string ending_of(const std::string &path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

bool begins_with(std::string_view beginning, std::string_view mark) {
  constexpr std::size_t head_of_xml = 400;
  return mark.front() == '<' ? beginning.substr(0, head_of_xml).find(mark) != beginning.npos
                             : beginning.starts_with(mark);
}

const Format *find_by_name(const std::string &path) {
  const std::string ending = ending_of(path);
  for (const Format &format : known_formats())
    if (std::find(format.endings.begin(), format.endings.end(), ending) != format.endings.end())
      return &format;
  return nullptr;
}

const Format *find_by_beginning(std::string_view beginning) {
  for (const Format &format : known_formats())
    if (std::any_of(format.marks.begin(), format.marks.end(),
                    [&](std::string_view mark) { return begins_with(beginning, mark); }))
      return &format;
  return nullptr;
}

std::string way_to_convert(const Format &format, const std::string &from, const std::string &to) {
  const std::string by_meshio = "meshio convert " + from + " " + to + " --output-format gmsh";
  switch (format.content) {
    case Content::mesh:
      return "convert it: " + by_meshio;
    case Content::gmsh_too:
      return "convert it: " + by_meshio + ", or gmsh " + from + " -save -o " + to;
    case Content::surface:
      return "fill it with tetrahedra first, for example with Gmsh or TetGen";
    case Content::geometry:
      break;
  }
  return "mesh it first: gmsh -3 " + from + " -o " + to;
}

}  // namespace

bool has_foreign_name(const std::string &path) {
  return find_by_name(path) != nullptr;
}

std::string advice_on_format(const std::string &path, std::string_view beginning) {
  const std::string read = "Medit .mesh (ASCII) and Gmsh .msh 2.2 and 4.1";
  const Format *format = find_by_name(path);
  if (!format) format = find_by_beginning(beginning);
  if (!format)
    return "is not in a format that is read, which are " + read +
           "; convert the mesh to one of them, by meshio convert or gmsh -save";
  const std::filesystem::path name(path);
  const std::string from = name.filename().string();
  const std::string to = name.stem().string() + (ending_of(from) == ".msh" ? "_gmsh.msh" : ".msh");
  return "is " + std::string(format->name) + ", a format that is not read, which are " + read +
         "; " + way_to_convert(*format, from, to);
}

}  // namespace trefoil
