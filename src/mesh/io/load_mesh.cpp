#include "mesh/io/load_mesh.hpp"

#include <cmath>
#include <sstream>

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

using Check = std::function<void(const CellList &, const std::string &)>;

/// What was found in a file's mesh, and what was done about it.
struct Findings {
  PetscInt repeated = 0, unused = 0;
  RepairReport repair;
};

/// A whole mesh, ready to be distributed; known on the first rank.
struct WholeMesh {
  CellList cells;
  PetscInt coincident = 0;
  std::string text;  ///< what was done to it, a line each
};

/// Refines, as the distributed mesh can where its cells are linear, and adds midpoints of edges.
void make_quadratic(const MeshOptions &options, CellList &whole) {
  const PetscInt refine = options.generate.empty() ? options.refine : 0;
  for (PetscInt level = 0; level < refine && !is_quadratic(*whole.shape); ++level) {
    if (8. * whole.shape->children * static_cast<double>(whole.cells.size()) >
        static_cast<double>(PETSC_MAX_INT))
      throw InputError("-mesh_refine " + std::to_string(refine) +
                       " would make more cells than can be numbered; refine less");
    refine_uniformly(whole);
  }
  promote_to_quadratic(whole);
}

/// What was done to a mesh, a line each, which begins with `start`.
std::string text_of(const Findings &findings, const CellShape &shape, const std::string &start) {
  std::string text;
  const RepairReport &repair = findings.repair;
  if (findings.repeated) {
    text += start + "took " + counted(findings.repeated, shape) +
            " once, in all groups, that the file has more than once\n";
  }
  if (repair.turned) {
    text += start + "turned all " + counted(repair.turned, shape) +
            " round, which the file has the other way round\n";
  }
  if (repair.dropped) {
    text += start + "dropped " + counted(repair.dropped, shape) + " without positive volume";
    if (repair.opened) {
      text += ", which leaves holes: " + counted(repair.opened, *shape.facet) +
              " inside of the body are surface now";
    }
    text += "\n";
  }
  if (findings.unused) {
    text += start + "dropped " + std::to_string(findings.unused) + " vertices that no " +
            shape.singular + " uses\n";
  }
  return text;
}

std::string name_of(const BodySource &source) {
  return source.file.empty() ? "generated " + source.generate : source.file;
}

/// What one file has, or what is generated, as elements can be made of it. Throws InputError.
CellList prepare_body(const MeshOptions &options, const BodySource &source, PetscInt refine,
                      const Check &check, std::string *text) {
  const std::string name = name_of(source);
  if (!source.name.empty() && is_hdf5_file(source.file))
    throw InputError(name +
                     " is HDF5, which all ranks read in shares: it can be the only mesh of "
                     "a scene (-mesh_file); a body comes from a Medit or Gmsh file");
  CellList mesh = source.file.empty() ? generate_mesh(source.generate, source.resolution, refine)
                                      : read_mesh(source.file);
  Findings findings;
  number_as_in_file(mesh);
  place(mesh, source.placement);
  if (options.order == 1) drop_midpoints(mesh);
  findings.repeated = take_once(mesh, name);
  check_node_order(mesh, name);
  findings.repair =
      repair_rest_shape(mesh, options.drops_bad_cells ? Repair::drop : Repair::none, name);
  check(mesh, name);
  findings.unused = drop_unused_vertices(mesh);
  *text += text_of(findings, *mesh.shape,
                   source.name.empty() ? "mesh: " : "mesh: " + source.name + ": ");
  return mesh;
}

/// The whole mesh, on the first rank, ready to be distributed. Throws InputError.
WholeMesh prepare_mesh(const MeshOptions &options, const Check &check) {
  WholeMesh whole;
  if (options.bodies.empty()) {
    const BodySource only{"", options.file, options.generate, options.resolution, {}};
    whole.cells = prepare_body(options, only, options.refine, check, &whole.text);
  } else {
    std::vector<CellList> meshes;
    for (const BodySource &body : options.bodies) {
      meshes.push_back(prepare_body(options, body, 0, check, &whole.text));
    }
    whole.cells = join_bodies(meshes, options.bodies);
  }
  if (options.order == 2) make_quadratic(options, whole.cells);
  if (options.normalize) normalize(whole.cells);
  order_along_curve(whole.cells);
  whole.coincident = coincident_vertices(whole.cells);
  return whole;
}

/// Tells all ranks the bodies that the first one knows.
PetscErrorCode tell_bodies(MPI_Comm comm, const std::vector<BodyNumbers> &whole, Mesh *mesh) {
  std::string names;
  std::vector<PetscInt> first;
  PetscFunctionBeginUser;
  for (const BodyNumbers &body : whole) {
    names += body.name + '\n';
    first.push_back(body.first_vertex);
  }
  PetscMPIInt sizes[2] = {static_cast<PetscMPIInt>(names.size()),
                          static_cast<PetscMPIInt>(first.size())};
  PetscCallMPI(MPI_Bcast(sizes, 2, MPI_INT, 0, comm));
  names.resize(static_cast<std::size_t>(sizes[0]));
  first.resize(static_cast<std::size_t>(sizes[1]));
  PetscCallMPI(MPI_Bcast(names.data(), sizes[0], MPI_CHAR, 0, comm));
  PetscCallMPI(MPI_Bcast(first.data(), sizes[1], MPIU_INT, 0, comm));
  std::istringstream lines(names);
  for (const PetscInt number : first) {
    BodyNumbers body{"", number};
    std::getline(lines, body.name);
    mesh->bodies.push_back(body);
  }
  PetscFunctionReturn(PETSC_SUCCESS);
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

/// "mesh: two.msh, 16 vertices, 12 tetrahedra, 2 unconnected parts (4 vertices coincide)"
PetscErrorCode print_mesh(MPI_Comm comm, const std::string &name, PetscInt coincident,
                          const Mesh &mesh) {
  PetscMPIInt ranks = 0;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(comm, &ranks));
  const bool quadratic = is_quadratic(*mesh.shape);
  PetscCall(PetscPrintf(comm, "mesh: %s, %" PetscInt_FMT " %s, %" PetscInt_FMT " %s%s",
                        name.c_str(), mesh.total_vertices, quadratic ? "nodes" : "vertices",
                        mesh.total_cells, quadratic ? "quadratic " : "",
                        mesh.total_cells == 1 ? mesh.shape->singular : mesh.shape->plural));
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

std::string MeshOptions::name() const {
  if (bodies.empty()) return name_of({"", file, generate, 0, {}});
  return std::to_string(bodies.size()) + " bodies (" + names_of(bodies) + ")";
}

PetscErrorCode load_mesh(MPI_Comm comm, const MeshOptions &options, const Check &check,
                         Mesh *mesh) {
  PetscMPIInt rank = 0;
  WholeMesh whole;
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
  if (rank == 0) complaint = complaint_of([&] { whole = prepare_mesh(options, check); });
  PetscCall(agree_on_complaint(comm, complaint));
  PetscCall(PetscPrintf(comm, "%s", whole.text.c_str()));
  // A generated mesh was refined where it was generated, true to its curved boundary.
  // So was one that was made quadratic.
  const PetscInt refine = options.generate.empty() && options.order != 2 ? options.refine : 0;
  PetscCall(check_refined_size(comm, whole.cells, refine));
  PetscCall(distribute_mesh(comm, whole.cells, options.partitioner, refine, mesh));
  PetscCall(tell_bodies(comm, whole.cells.bodies, mesh));
  PetscCall(print_mesh(comm, options.name(), whole.coincident, *mesh));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
