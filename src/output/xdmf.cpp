#include "output/xdmf.hpp"

#include <cstdio>
#include <sstream>

#include "output/hdf5_file.hpp"

namespace trefoil {
namespace {

/// An array of rows x columns, or a plain list where there is one column.
std::string data_item(const std::string &number, PetscInt rows, int columns,
                      const std::string &data_file, const std::string &dataset) {
  std::ostringstream text;
  text << "<DataItem Format=\"HDF\" " << number << " Dimensions=\"" << rows;
  if (columns > 1) text << ' ' << columns;
  text << "\">" << escaped_for_xml(data_file + ":" + dataset) << "</DataItem>";
  return text.str();
}

const char *attribute_type(int components) {
  switch (components) {
    case 1:
      return "Scalar";
    case 3:
      return "Vector";
    case 6:
      return "Tensor6";
    case 9:
      return "Tensor";
    default:
      return "Matrix";
  }
}

/// A number that reads back as it was.
std::string exactly(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

}  // namespace

std::string escaped_for_xml(const std::string &text) {
  std::string result;
  for (const char letter : text)
    result += letter == '&'   ? "&amp;"
              : letter == '<' ? "&lt;"
              : letter == '>' ? "&gt;"
              : letter == '"' ? "&quot;"
                              : std::string(1, letter);
  return result;
}

XdmfFrame frame_in_xdmf(bool is_series, const std::vector<std::string> &obstacles) {
  std::string names;
  for (const std::string &name : obstacles) names += (names.empty() ? "" : " ") + name;
  if (!names.empty()) names = " Obstacles=\"" + escaped_for_xml(names) + "\"";
  const std::string series =
      "    <Grid Name=\"states\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  return {std::string("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Xdmf Version=\"3.0\">\n") +
              "  <Domain" + names + ">\n" + (is_series ? series : ""),
          std::string(is_series ? "    </Grid>\n" : "") + "  </Domain>\n</Xdmf>\n"};
}

std::string describe_in_xdmf(const std::string &mesh_file, const ArrangedMesh &mesh,
                             const XdmfState &state) {
  const std::string integer =
      "NumberType=\"Int\" Precision=\"" + std::to_string(sizeof(PetscInt)) + "\"";
  const std::string real = R"(NumberType="Float" Precision="8")";
  const std::string root = "/";
  std::ostringstream text;
  text << "    <Grid Name=\"body\" GridType=\"Uniform\">\n";
  if (state.has_time) text << "      <Time Value=\"" << exactly(state.t) << "\"/>\n";
  text << "      <Topology TopologyType=\"" << mesh.shape->xdmf << "\" NumberOfElements=\""
       << mesh.total_cells << (mesh.shape->dimension == 1 ? "\" NodesPerElement=\"2" : "")
       << "\">\n        "
       << data_item(integer, mesh.total_cells, mesh.shape->nodes, mesh_file, root + cells_dataset)
       << "\n      </Topology>\n      <Geometry GeometryType=\"XYZ\">\n        "
       << data_item(real, mesh.total_points, 3, mesh_file, root + points_dataset)
       << "\n      </Geometry>\n";
  for (const FieldKind &field : state.fields)
    text << "      <Attribute Name=\"" << escaped_for_xml(field.name) << "\" AttributeType=\""
         << attribute_type(field.components) << "\" Center=\""
         << (field.on_vertices ? "Node" : "Cell") << "\">\n        "
         << data_item(real, field.on_vertices ? mesh.total_points : mesh.total_cells,
                      field.components, state.data_file, dataset_of(field))
         << "\n      </Attribute>\n";
  text << "    </Grid>\n";
  return text.str();
}

}  // namespace trefoil
