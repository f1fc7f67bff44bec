#pragma once

#include <petscsys.h>

#include "output/arranged.hpp"

namespace trefoil {

/// Writes an unstructured grid in VTK's XML format into `file`, which is there: a head of XML, then
/// all arrays as raw bytes, which the ranks write together. Collective, but where the disk fails on
/// some ranks the outcome may differ between ranks. Format: "VTK File Formats", www.vtk.org.
PetscErrorCode write_vtu(MPI_Comm comm, const std::string &file, const ArrangedMesh &mesh,
                         const std::vector<ArrangedField> &fields);

/// Room that the file needs, in bytes.
PetscInt64 size_in_vtu(const ArrangedMesh &mesh, const std::vector<ArrangedField> &fields);

/// One of a series of such files.
struct VtuOfSeries {
  double t = 0;
  std::string file;  ///< seen from the list
};

/// The whole text of ParaView's list of a series, a .pvd file.
std::string describe_in_pvd(const std::vector<VtuOfSeries> &files);

}  // namespace trefoil
