#include "body_problem.hpp"

#include <petsctime.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "term/elastic_term.hpp"
#include "trefoil.h"

namespace trefoil::accuracy {
namespace {

// Gauss and Legendre's rule of four points on [0, 1].
constexpr double gauss_points[4] = {0.069431844202973712, 0.33000947820757187, 0.66999052179242813,
                                    0.93056815579702629};
constexpr double gauss_weights[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                     0.17392742256872693};

/// Points and weights on the reference simplex: a square or cube of Gauss points, collapsed.
std::vector<std::array<double, 4>> collapsed_rule(int dim) {
  std::vector<std::array<double, 4>> rule;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < (dim == 3 ? 4 : 1); ++k) {
        const double x = gauss_points[i], y = gauss_points[j] * (1 - x);
        double z = 0, weight = gauss_weights[i] * gauss_weights[j] * (1 - x);
        if (dim == 3) {
          z = gauss_points[k] * (1 - x - y);
          weight *= gauss_weights[k] * (1 - x - y);
        }
        rule.push_back({x, y, z, weight});
      }
  return rule;
}

}  // namespace

Problem::~Problem() {
  static_cast<void>(VecDestroy(&x_));  // errors have nowhere to go from here
  static_cast<void>(MatDestroy(&H_));
}

PetscErrorCode Problem::set_up(const CellList &whole, std::unique_ptr<MaterialModel> material,
                               const Prescribed &prescribed, ElementPressure pressure) {
  PetscFunctionBeginUser;
  PetscCall(distribute_mesh(PETSC_COMM_WORLD, whole, "metis", 0, &mesh));
  HeldDofs held = nothing_held(mesh);
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    for (int i = 0; i < mesh.dimension(); ++i) {
      const std::optional<double> value = prescribed(&mesh.coordinates[3 * v], i);
      if (!value) continue;
      held.held[3 * v + static_cast<std::size_t>(i)] = 1;
      held.value[3 * v + static_cast<std::size_t>(i)] = *value;
    }
  }
  PetscCall(discretization.set_up(mesh, held));
  forces_.assign(mesh.coordinates.size(), 0);
  auto elastic =
      std::make_unique<ElasticTerm>(mesh, std::move(material), FilterSpace::element, pressure);
  elastic_ = elastic.get();
  functional_ = std::make_unique<EnergyFunctional>(discretization);
  functional_->add_term(std::move(elastic));
  functional_->add_term(std::make_unique<DeadLoadTerm>([this](double, std::vector<double> *forces) {
    *forces = forces_;
    return PETSC_SUCCESS;
  }));
  PetscCall(discretization.create_vector(&x_));
  PetscCall(discretization.create_matrix(&H_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<CellPoint> Problem::points(PetscInt cell) const {
  const int nodes = mesh.nodes_per_cell(), dim = mesh.dimension();
  static const std::vector<std::array<double, 4>> rules[2] = {collapsed_rule(2), collapsed_rule(3)};
  std::vector<CellPoint> result;
  for (const auto &[r, s, t, weight] : rules[dim - 2]) {
    const double reference[3] = {r, s, t};
    double gradients[ReferenceElement::most_nodes][3] = {};
    CellPoint point{};
    shape_functions(dim, nodes, reference, point.values, gradients);
    Matrix3<double> J;
    if (dim == 2) J(2, 2) = 1;
    for (int a = 0; a < nodes; ++a) {
      const double *p = &mesh.coordinates[static_cast<std::size_t>(
          3 * mesh.cells[static_cast<std::size_t>(nodes * cell + a)])];
      for (int i = 0; i < 3; ++i) point.position[i] += point.values[a] * p[i];
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j) J(i, j) += p[i] * gradients[a][j];
    }
    const Matrix3<double> C = cofactor(J);
    point.weight = weight * determinant(J);
    for (int a = 0; a < nodes; ++a)
      for (int i = 0; i < dim; ++i)
        for (int j = 0; j < dim; ++j)
          point.gradients[a][i] += gradients[a][j] * C(i, j) / determinant(J);
    result.push_back(point);
  }
  return result;
}

void Problem::add_body_force(const VectorField &force) {
  for (PetscInt c = 0; c < mesh.local_cells(); ++c)
    for (const CellPoint &point : points(c)) {
      const std::array<double, 3> b = force(point.position);
      for (int a = 0; a < mesh.nodes_per_cell(); ++a) {
        const auto node = static_cast<std::size_t>(
            mesh.cells[static_cast<std::size_t>(mesh.nodes_per_cell() * c + a)]);
        for (std::size_t i = 0; i < static_cast<std::size_t>(mesh.dimension()); ++i)
          forces_[3 * node + i] += point.weight * point.values[a] * b[i];
      }
    }
}

void Problem::add_edge_force(double x, const std::array<double, 2> &total) {
  constexpr int edges[3][2] = {{0, 1}, {1, 2}, {2, 0}};
  const auto nodes = static_cast<std::size_t>(mesh.nodes_per_cell());
  std::vector<double> share(mesh.owned.size(), 0);  // of the length of the edge
  double length = 0;
  for (std::size_t c = 0; c < mesh.cells.size(); c += nodes)
    for (int e = 0; e < 3; ++e) {
      const auto a =
          static_cast<std::size_t>(mesh.cells[c + static_cast<std::size_t>(edges[e][0])]);
      const auto b =
          static_cast<std::size_t>(mesh.cells[c + static_cast<std::size_t>(edges[e][1])]);
      const double *p = &mesh.coordinates[3 * a], *q = &mesh.coordinates[3 * b];
      if (std::abs(p[0] - x) > 1e-9 || std::abs(q[0] - x) > 1e-9) continue;
      const double size = std::abs(q[1] - p[1]);
      length += size;
      // Simpson's rule for quadratic edges, the trapezoidal one for linear ones: both exact.
      share[a] += size / (nodes == 6 ? 6 : 2);
      share[b] += size / (nodes == 6 ? 6 : 2);
      if (nodes == 6)
        share[static_cast<std::size_t>(mesh.cells[c + 3 + static_cast<std::size_t>(e)])] +=
            size * 2 / 3;
    }
  MPI_Allreduce(MPI_IN_PLACE, &length, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  for (std::size_t v = 0; v < share.size(); ++v)
    for (std::size_t i = 0; i < 2; ++i) forces_[3 * v + i] += total[i] * share[v] / length;
}

void Problem::scale_forces(double factor) {
  for (double &force : forces_) force *= factor;
}

PetscErrorCode Problem::start_from(const VectorField &displacement) {
  PetscFunctionBeginUser;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
    const std::array<double, 3> value = displacement(&mesh.coordinates[3 * v]);
    for (std::size_t i = 0; mesh.owned[v] && i < 3; ++i) {
      const PetscInt dof = discretization.global_dofs()[3 * v + i];
      if (dof >= 0) PetscCall(VecSetValue(x_, dof, value[i], INSERT_VALUES));
    }
  }
  PetscCall(VecAssemblyBegin(x_));
  PetscCall(VecAssemblyEnd(x_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The filter finds the basin, where Newton's method, unfiltered, converges faster.
PetscErrorCode Problem::solve(double energy_tolerance) {
  PetscLogDouble begin = 0, end = 0;
  PetscFunctionBeginUser;
  PetscCall(PetscTime(&begin));
  PetscCall(TrefoilInitializePackage());
  iterations = 0;
  PetscCall(functional_->set_time(1));  // takes the forces as they are
  PetscCall(solve_by("adaptive", std::max(1e-7, energy_tolerance)));
  PetscCall(solve_by("newton", energy_tolerance));
  PetscCall(PetscTime(&end));
  solve_seconds = end - begin;
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Problem::solve_by(const char *filter, double energy_tolerance) {
  SNES snes = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt count = 0;
  PetscMPIInt ranks = 1;
  PetscFunctionBeginUser;
  PetscCallMPI(MPI_Comm_size(PETSC_COMM_WORLD, &ranks));
  PetscCall(SNESCreate(PETSC_COMM_WORLD, &snes));
  PetscCall(functional_->attach(snes, H_, EnergyFunctional::Assembly::split));
  PetscCall(SNESSetType(snes, SNESTREFOIL));
  PetscCall(SNESSetTolerances(snes, 1e-300, 0, 0, 200, 100000));
  PetscCall(TrefoilSNESSetFilter(snes, filter));
  PetscCall(TrefoilSNESSetTolerances(snes, PETSC_DEFAULT, energy_tolerance));
  PetscCall(SNESGetKSP(snes, &ksp));
  PetscCall(KSPSetType(ksp, KSPPREONLY));
  PetscCall(KSPGetPC(ksp, &pc));
  // Newton's matrices may be indefinite, which MUMPS survives.
  const bool definite = ranks == 1 && std::string(filter) != "newton";
  PetscCall(PCSetType(pc, PCCHOLESKY));
  PetscCall(PCFactorSetMatSolverType(pc, definite ? MATSOLVERCHOLMOD : MATSOLVERMUMPS));
  PetscCall(SNESSetFromOptions(snes));
  PetscCall(SNESSolve(snes, nullptr, x_));
  PetscCall(SNESGetConvergedReason(snes, &reason));
  PetscCall(SNESGetIterationNumber(snes, &count));
  PetscCall(SNESDestroy(&snes));
  iterations += static_cast<int>(count);
  PetscCheck(reason > 0, PETSC_COMM_WORLD, PETSC_ERR_CONV_FAILED, "the solve ended with %s",
             SNESConvergedReasons[reason]);
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode Problem::displacements(std::vector<double> *u) const {
  Vec local = nullptr;
  const PetscScalar *values = nullptr;
  PetscFunctionBeginUser;
  PetscCall(discretization.get_local(x_, &local, &values));
  u->assign(values, values + mesh.coordinates.size());
  PetscCall(discretization.restore_local(&local, &values));
  PetscFunctionReturn(PETSC_SUCCESS);
}

std::vector<double> Problem::forces(const std::vector<double> &u) const {
  std::vector<double> result(u.size(), 0);
  PetscCallAbort(PETSC_COMM_WORLD, elastic_->add_gradient(u.data(), result.data()));
  return result;
}

double Problem::elastic_energy(const std::vector<double> &u) const {
  EnergySums sums;
  PetscCallAbort(PETSC_COMM_WORLD, elastic_->add_energy(u.data(), &sums));
  MPI_Allreduce(MPI_IN_PLACE, &sums.energy, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return sums.energy;
}

double Problem::work(const std::vector<double> &u) const {
  double sum = 0;
  for (std::size_t k = 0; k < u.size(); ++k) sum += forces_[k] * u[k];
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return sum;
}

Problem::Errors Problem::errors(const std::vector<double> &u, const VectorField &displacement,
                                const TensorField &gradient) const {
  double sums[4] = {0, 0, 0, 0};  // squares of errors and norms
  for (PetscInt c = 0; c < mesh.local_cells(); ++c)
    for (const CellPoint &point : points(c)) {
      const std::array<double, 3> exact = displacement(point.position);
      const Matrix3<double> F = gradient(point.position);
      for (int i = 0; i < mesh.dimension(); ++i) {
        double value = 0, slope[3] = {0, 0, 0};
        for (int a = 0; a < mesh.nodes_per_cell(); ++a) {
          const auto node = static_cast<std::size_t>(
              mesh.cells[static_cast<std::size_t>(mesh.nodes_per_cell() * c + a)]);
          const double u_a = u[3 * node + static_cast<std::size_t>(i)];
          value += point.values[a] * u_a;
          for (int j = 0; j < mesh.dimension(); ++j) slope[j] += point.gradients[a][j] * u_a;
        }
        const double true_value = exact[static_cast<std::size_t>(i)];
        sums[0] += point.weight * (value - true_value) * (value - true_value);
        sums[1] += point.weight * true_value * true_value;
        for (int j = 0; j < mesh.dimension(); ++j) {
          const double true_slope = F(i, j) - (i == j ? 1 : 0);
          sums[2] += point.weight * (slope[j] - true_slope) * (slope[j] - true_slope);
          sums[3] += point.weight * true_slope * true_slope;
        }
      }
    }
  MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return {std::sqrt(sums[0] / sums[1]), std::sqrt(sums[2] / sums[3])};
}

}  // namespace trefoil::accuracy
