#include "mesh/io/load_mesh.hpp"

#include <cmath>

#include "mesh/check_mesh.hpp"
#include "mesh/generate.hpp"
#include "mesh/io/hdf5_mesh.hpp"
#include "mesh/io/read_mesh.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"
#include "mesh/refine.hpp"
#include "mesh/repeated.hpp"
#include "support/collective_error.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// What was found in the mesh, and what was done about it; known on the first rank.
struct Findings {
  PetscInt repeated = 0, unused = 0, coincident = 0;
  RepairReport repair;
};

/// Refines, as the distributed mesh can where its cells are linear, and adds midpoints of edges.
void make_quadratic(const MeshOptions &options, CellList &whole) {
  const PetscInt refine = options.file.empty() ? 0 : options.refine;
  for (PetscInt level = 0; level < refine && !is_quadratic(*whole.shape); ++level) {
    if (8. * whole.shape->children * static_cast<double>(whole.cells.size()) >
        static_cast<double>(PETSC_MAX_INT))
      throw InputError("-mesh_refine " + std::to_string(refine) +
                       " would make more cells than can be numbered; refine less");
    refine_uniformly(whole);
  }
  promote_to_quadratic(whole);
}

/// The whole mesh, on the first rank, ready to be distributed. Throws InputError.
CellList prepare_mesh(const MeshOptions &options,
                      const std::function<void(const CellList &)> &check, Findings *findings) {
  CellList whole = options.file.empty()
                       ? generate_mesh(options.generate, options.resolution, options.refine)
                       : read_mesh(options.file);
  number_as_in_file(whole);
  if (options.order == 1) drop_midpoints(whole);
  findings->repeated = take_once(whole, options.name());
  check_node_order(whole, options.name());
  findings->repair = repair_rest_shape(whole, options.drops_bad_cells ? Repair::drop : Repair::none,
                                       options.name());
  check(whole);
  findings->unused = drop_unused_vertices(whole);
  if (options.order == 2) make_quadratic(options, whole);
  if (options.normalize) normalize(whole);
  order_along_curve(whole);
  findings->coincident = coincident_vertices(whole);
  return whole;
}

/// Refuses what PetscInt cannot number: each refinement cuts a tetrahedron into eight.
PetscErrorCode check_refined_size(MPI_Comm comm, const CellList &whole, PetscInt refine) {
  PetscInt shape[2] = {whole.size(), whole.shape->order};  // known on the first rank
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Bcast(shape, 2, MPIU_INT, 0, comm));
  PetscCheck(shape[1] == 1 || refine == 0, comm, PETSC_ERR_USER_INPUT,
             "-mesh_refine works on linear cells, and the mesh's are quadratic; refine it in the "
             "mesher, or give -order 1");
  const double entries = 4. * shape[0] * std::pow(8., refine);
  PetscCheck(entries < static_cast<double>(PETSC_MAX_INT), comm, PETSC_ERR_USER_INPUT,
             "-mesh_refine %" PetscInt_FMT " would make more than %.1g tetrahedra; refine less",
             refine, static_cast<double>(PETSC_MAX_INT) / 4);
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What was done to the mesh, a line each.
std::string text_of(const Findings &findings, const CellShape &shape) {
  std::string text;
  const RepairReport &repair = findings.repair;
  if (findings.repeated) {
    text += "mesh: took " + counted(findings.repeated, shape) +
            " once, in all groups, that the file has more than once\n";
  }
  if (repair.turned) {
    text += "mesh: turned all " + counted(repair.turned, shape) +
            " round, which the file has the other way round\n";
  }
  if (repair.dropped) {
    text += "mesh: dropped " + counted(repair.dropped, shape) + " without positive volume";
    if (repair.opened) {
      text += ", which leaves holes: " + counted(repair.opened, *shape.facet) +
              " inside of the body are surface now";
    }
    text += "\n";
  }
  if (findings.unused) {
    text += "mesh: dropped " + std::to_string(findings.unused) + " vertices that no " +
            shape.singular + " uses\n";
  }
  return text;
}

/// "mesh: two.msh, 16 vertices, 12 tetrahedra, 2 unconnected parts (4 vertices coincide)"
PetscErrorCode print_mesh(MPI_Comm comm, const std::string &name, PetscInt coincident,
                          const Mesh &mesh) {
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  const bool quadratic = is_quadratic(*mesh.shape);
  PetscCall(PetscPrintf(comm, "mesh: %s, %" PetscInt_FMT " %s, %" PetscInt_FMT " %s%s",
                        name.c_str(), mesh.total_vertices, quadratic ? "nodes" : "vertices",
                        mesh.total_cells, quadratic ? "quadratic " : "", mesh.shape->plural));
  if (mesh.parts > 1) {
    PetscCall(PetscPrintf(comm, ", %" PetscInt_FMT " unconnected parts", mesh.parts));
  }
  if (coincident) {
    PetscCall(PetscPrintf(comm, " (%" PetscInt_FMT " %s)", coincident,
                          coincident == 1 ? "vertex coincides" : "vertices coincide"));
  }
  if (ranks > 1) {
    PetscCall(PetscPrintf(comm, " on %d ranks, edge cut %" PetscInt_FMT ", imbalance %.3f", ranks,
                          mesh.edge_cut, mesh.imbalance));
  }
  PetscCall(PetscPrintf(comm, "\n"));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What can be done only where one rank has the whole mesh, so before it is written in HDF5.
PetscErrorCode check_options_of_shares(MPI_Comm comm, const MeshOptions &options,
                                       const Mesh &mesh) {
  PetscFunctionBeginUser;
  PetscCheck(options.order == 0 || options.order == mesh.shape->order, comm, PETSC_ERR_USER_INPUT,
             "the cells of %s are not of -order %" PetscInt_FMT
             "; give -order where the file is made, beside -mesh_write",
             options.file.c_str(), options.order);
  PetscCheck(!options.normalize && !options.drops_bad_cells, comm, PETSC_ERR_USER_INPUT,
             "%s is read by all ranks in shares, which neither -mesh_normalize nor -mesh_repair "
             "can do; give them where the file is made, beside -mesh_write",
             options.file.c_str());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

PetscErrorCode load_mesh(MPI_Comm comm, const MeshOptions &options,
                         const std::function<void(const CellList &)> &check, Mesh *mesh) {
  PetscMPIInt rank = 0;
  Findings findings;
  CellList whole;
  std::string complaint;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_rank(comm, &rank));
  int in_shares = rank == 0 && is_hdf5_file(options.file);
  PetscCallMPI(MPI_Bcast(&in_shares, 1, MPI_INT, 0, comm));
  if (in_shares) {
    PetscCall(read_hdf5_mesh(comm, options.file, options.partitioner, options.refine, mesh));
    PetscCall(check_options_of_shares(comm, options, *mesh));
    PetscCall(print_mesh(comm, options.name(), 0, *mesh));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  if (rank == 0) complaint = complaint_of([&] { whole = prepare_mesh(options, check, &findings); });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscCall(PetscPrintf(comm, "%s", text_of(findings, *whole.shape).c_str()));
  // A generated mesh was refined where it was generated, true to its curved boundary.
  // So was one that was made quadratic.
  const PetscInt refine = options.file.empty() || options.order == 2 ? 0 : options.refine;
  PetscCall(check_refined_size(comm, whole, refine));
  PetscCall(distribute_mesh(comm, whole, options.partitioner, refine, mesh));
  PetscCall(print_mesh(comm, options.name(), findings.coincident, *mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
