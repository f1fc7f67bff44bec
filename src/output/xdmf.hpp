#pragma once

#include <string>
#include <vector>

#include "output/arranged.hpp"

/// The light half of an output: what the datasets of its HDF5 files mean, in XDMF 3.
namespace trefoil {

/// One state of a mesh.
struct XdmfState {
  bool has_time = false;
  double t = 0;
  std::string data_file;  ///< name of the HDF5 file with its fields, seen from the XDMF file
  std::vector<FieldKind> fields;
};

/// What stands before the states and behind them.
struct XdmfFrame {
  std::string head, tail;
};
/// @param obstacles their names are an attribute of the domain, of which readers of XDMF know
/// nothing
XdmfFrame frame_in_xdmf(bool is_series, const std::vector<std::string> &obstacles);

/// The text of one state.
/// @param mesh_file name of the HDF5 file with the mesh, seen from the directory of the XDMF file
/// @param mesh only its shape and its totals count
std::string describe_in_xdmf(const std::string &mesh_file, const ArrangedMesh &mesh,
                             const XdmfState &state);

/// Text as it may stand in an XML attribute or between tags.
std::string escaped_for_xml(const std::string &text);

}  // namespace trefoil
