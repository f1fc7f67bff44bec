#include "output/xdmf.hpp"

#include <sstream>

namespace trefoil::xdmf {
namespace {

/// Text as it may stand in an XML attribute or between tags.
std::string escaped(const std::string &text) {
  std::string result;
  for (const char letter : text)
    result += letter == '&'   ? "&amp;"
              : letter == '<' ? "&lt;"
              : letter == '>' ? "&gt;"
              : letter == '"' ? "&quot;"
                              : std::string(1, letter);
  return result;
}

/// An array of rows x columns, or a plain list where there is one column.
std::string data_item(const std::string &number, PetscInt64 rows, int columns,
                      const std::string &data_file, const std::string &dataset) {
  std::ostringstream text;
  text << "<DataItem Format=\"HDF\" " << number << " Dimensions=\"" << rows;
  if (columns > 1) text << ' ' << columns;
  text << "\">" << escaped(data_file + ":" + dataset) << "</DataItem>";
  return text.str();
}

}  // namespace

const char *group_of(const Snapshot::Field &field) {
  return field.on_vertices ? "/vertex_fields" : "/cell_fields";
}

std::string describe(const std::string &data_file, const Snapshot &snapshot, const Totals &totals) {
  const std::string integer =
      "NumberType=\"Int\" Precision=\"" + std::to_string(sizeof(PetscInt)) + "\"";
  const std::string real = R"(NumberType="Float" Precision="8")";
  const char *shape = snapshot.corners == 4    ? "Tetrahedron"
                      : snapshot.corners == 10 ? "Tetrahedron_10"
                      : snapshot.corners == 6  ? "Triangle_6"
                                               : "Triangle";

  std::ostringstream text;
  text << R"(<?xml version="1.0" encoding="UTF-8"?>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="body" GridType="Uniform">
      <Topology TopologyType=")"
       << shape << R"(" NumberOfElements=")" << totals.cells << "\">\n        "
       << data_item(integer, totals.cells, snapshot.corners, data_file,
                    std::string("/") + cells_dataset)
       << R"(
      </Topology>
      <Geometry GeometryType="XYZ">
        )"
       << data_item(real, totals.points, coordinates, data_file, std::string("/") + points_dataset)
       << "\n      </Geometry>\n";
  for (const auto &field : snapshot.fields)
    text << "      <Attribute Name=\"" << escaped(field.name) << "\" AttributeType=\""
         << (field.components == 1 ? "Scalar" : "Vector") << "\" Center=\""
         << (field.on_vertices ? "Node" : "Cell") << "\">\n        "
         << data_item(real, field.on_vertices ? totals.points : totals.cells, field.components,
                      data_file, std::string(group_of(field)) + "/" + field.name)
         << "\n      </Attribute>\n";
  text << "    </Grid>\n  </Domain>\n</Xdmf>\n";
  return text.str();
}

}  // namespace trefoil::xdmf
