#pragma once

#include <string>
#include <vector>

#include "mesh/mesh.hpp"
#include "output/run_report.hpp"
#include "scene/scene_options.hpp"

namespace trefoil {

/// Places of the body whose displacement is asked for: cells and shape functions there, found once.
class Probes {
 public:
  /// Finds the places in the body at rest. Collective; `mesh` must outlive this. A place outside of
  /// it is an error with one sentence on all ranks, which names the nearest vertex.
  PetscErrorCode find(const Mesh &mesh, const std::vector<ProbeOptions> &options);

  /// Their displacements, on all ranks, from local displacements u, 3 a local vertex. Collective.
  PetscErrorCode report(const double *u, std::vector<ProbeReport> *reports) const;

 private:
  struct Probe {
    std::string name;
    std::vector<PetscInt> vertices;  ///< of its cell; empty on all ranks but one
    std::vector<double> values;      ///< of the cell's shape functions there
  };
  PetscErrorCode find_one(const ProbeOptions &options, Probe *probe) const;

  const Mesh *mesh_ = nullptr;
  std::vector<Probe> probes_;
};

}  // namespace trefoil
