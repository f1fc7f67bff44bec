// One row of the table of errors against unknowns, time and memory, in comma-separated values; run
// by table.py. A volume-preserving deformation of the unit square or cube with all the boundary
// held: its stresses do not depend on Poisson's ratio, so that what grows with it is locking.
//
//   table_case tri3|tri6|tri6_p0|tet4|tet10|tet10_p0 POISSON RESOLUTION
//
// _p0: with a constant pressure each, P2-P0.
//
// Prints: element, nu, resolution, unknowns, error L2, error H1, iterations, seconds, megabytes.

#include <cstdio>
#include <cstdlib>
#include <string>

#include "body_problem.hpp"
#include "manufactured.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "mesh/locality.hpp"
#include "mesh/quadratic.hpp"

using namespace trefoil;
using namespace trefoil::accuracy;

namespace {

PetscErrorCode run(const std::string &element, double poisson, PetscInt resolution) {
  const Manufactured exact{element.substr(0, 3) == "tri" ? 2 : 3, 0.08, 0};
  CellList mesh = generate_mesh(exact.dimension == 2 ? "square" : "box", resolution, 0);
  const bool is_linear = element == "tri3" || element == "tet4";
  const auto pressure =
      element.ends_with("_p0") ? ElementPressure::constant : ElementPressure::pointwise;
  if (!is_linear) promote_to_quadratic(mesh);
  order_along_curve(mesh);
  // The shear modulus is one whatever nu.
  const StableNeoHookean material({2 * (1 + poisson), poisson}, StableNeoHookean::Lame::physical);
  const auto model = make_material_model(material);
  Problem problem;
  std::vector<double> u;
  PetscLogDouble bytes = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscMemorySetGetMaximumUsage());
  PetscCall(problem.set_up(
      mesh, make_material_model(material),
      [&](const double *p, int i) -> std::optional<double> {
        for (int k = 0; k < exact.dimension; ++k)
          if (p[k] < 1e-9 || p[k] > 1 - 1e-9)
            return exact.displacement(p)[static_cast<std::size_t>(i)];
        return {};
      },
      pressure));
  problem.add_body_force([&](const double *p) { return exact.body_force(*model, p); });
  // From near the solution: from the moved boundary alone fine meshes crumple into other minima.
  PetscCall(problem.start_from([&](const double *p) { return exact.displacement(p); }));
  PetscCall(problem.solve(1e-12));
  PetscCall(PetscMemoryGetMaximumUsage(&bytes));
  PetscCall(problem.displacements(&u));
  const Problem::Errors errors = problem.errors(
      u, [&](const double *p) { return exact.displacement(p); },
      [&](const double *p) { return exact.gradient(p); });
  std::printf("%s,%g,%d,%d,%.4e,%.4e,%d,%.4f,%.1f\n", element.c_str(), poisson,
              static_cast<int>(resolution), static_cast<int>(problem.discretization.total_dofs()),
              errors.L2, errors.H1, problem.iterations, problem.solve_seconds, bytes / 1e6);
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

int main(int argc, char **argv) {
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  if (argc < 4) {
    std::fprintf(stderr, "usage: table_case ELEMENT POISSON RESOLUTION\n");
    return 1;
  }
  PetscCall(run(argv[1], std::atof(argv[2]), std::atoi(argv[3])));
  PetscCall(PetscFinalize());
  return 0;
}
