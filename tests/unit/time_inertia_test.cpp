// Masses, and inertia as a term: exact integrals, derivatives, and what the filter of the elements
// sees of it. Needs petsc_main.cpp.

#include <algorithm>
#include <array>
#include <numeric>

#include "body.hpp"
#include "element/mass_matrix.hpp"
#include "filter/filter.hpp"
#include "mesh/quadratic.hpp"
#include "term/inertia_term.hpp"

namespace trefoil::test {
namespace {

struct Kind {
  const char *name, *mesh;
  PetscInt resolution;
  int order;
  Holding holding;
  MassKind mass;
  bool bent;
};
const std::vector<Kind> kinds{
    {"tri3", "square", 5, 1, nothing, MassKind::consistent, false},
    {"tri3_lumped", "square", 5, 1, nothing, MassKind::lumped, false},
    {"tri6", "square", 4, 2, nothing, MassKind::consistent, false},
    {"tri6_bent", "square", 4, 2, nothing, MassKind::consistent, true},
    {"tet4", "box", 3, 1, bottom, MassKind::consistent, false},
    {"tet4_lumped", "box", 3, 1, bottom, MassKind::lumped, false},
    {"tet4_components", "box", 3, 1, bottom_and_sides, MassKind::consistent, false},
    {"tet10", "box", 2, 2, bottom, MassKind::consistent, false},
    {"tet10_bent", "box", 2, 2, bottom, MassKind::consistent, true},
};

/// Moves midpoints of edges, so that cells are bent.
void bend(CellList &whole) {
  for (std::size_t k = 0; k < whole.coordinates.size(); k += 3) {
    double *p = &whole.coordinates[k];
    const double x = p[0], y = p[1];
    p[0] += 0.08 * y * y;
    p[1] -= 0.06 * x * x;
  }
}

double density_at(const std::array<double, 3> &p) {
  return p[0] > 0.5 ? 3 : 7;
}

/// A body with inertia.
struct MovingBody : Body {
  std::shared_ptr<const MassMatrix> mass;
  const InertiaTerm *inertia = nullptr;
  const PackedElements *elements = nullptr;  ///< of an elastic term like the functional's
  std::unique_ptr<ElasticTerm> elastic;

  PetscErrorCode set_up(const Kind &kind, double damping, MPI_Comm comm = PETSC_COMM_WORLD) {
    PetscFunctionBeginUser;
    CellList whole = generate_mesh(kind.mesh, kind.resolution, 0);
    if (kind.order == 2) promote_to_quadratic(whole);
    if (kind.bent) bend(whole);
    PetscCall(distribute_mesh(comm, whole, "metis", 0, &mesh));
    held = nothing_held(mesh);
    for (std::size_t v = 0; v < mesh.owned.size(); ++v) {
      for (int i = 0; i < mesh.dimension(); ++i) {
        const auto dof = 3 * v + static_cast<std::size_t>(i);
        held.held[dof] = kind.holding(&mesh.coordinates[3 * v], i);
        if (held.held[dof]) held.value[dof] = 0.3 * crumpled(&mesh.coordinates[3 * v], i);
      }
    }
    PetscCall(discretization.set_up(mesh, held));
    functional = std::make_unique<EnergyFunctional>(discretization);
    const auto packs = pack_cells(mesh);
    const auto make = [&] {
      return std::make_unique<ElasticTerm>(
          mesh, packs, MaterialRuns(make_material_model(soft_material()), mesh.local_cells()),
          FilterSpace::element);
    };
    elastic = make();
    elements = elastic->batch();
    functional->add_term(make());
    std::vector<double> density;
    for (std::size_t c = 0; c < static_cast<std::size_t>(mesh.local_cells()); ++c) {
      density.push_back(density_at(centroid_of_cell(mesh, c)));
    }
    mass = std::make_shared<MassMatrix>(mesh, std::move(density), kind.mass);
    auto term = std::make_unique<InertiaTerm>(mass, *packs, damping);
    inertia = term.get();
    functional->add_term(std::move(term));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  [[nodiscard]] std::vector<double> local(const Field &field) const {
    std::vector<double> values(mesh.coordinates.size(), 0);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const int i = static_cast<int>(k % 3);
      if (i < mesh.dimension()) values[k] = field(&mesh.coordinates[k - k % 3], i);
    }
    return values;
  }
};

double small(const double *p, int i) {
  return 0.3 * crumpled(p, i);
}
double predicted_field(const double *p, int i) {
  return 0.2 * p[(i + 1) % 2] + 0.05 * noise(p, i + 7);
}
double origin_field(const double *p, int i) {
  return 0.1 * p[i] - 0.05 * noise(p, i + 11);
}

class TimeInertiaTest : public testing::TestWithParam<Kind> {
 protected:
  static constexpr double step = 0.07, velocity_time = 0.05, damping = 3;
  void SetUp() override { ASSERT_EQ(body_.set_up(GetParam(), damping), PETSC_SUCCESS); }
  void begin_step() {
    predicted_ = body_.local(predicted_field);
    origin_ = body_.local(origin_field);
    ASSERT_EQ(body_.functional->begin_step(
                  {1, step, step, predicted_.data(), velocity_time, origin_.data()}),
              PETSC_SUCCESS);
  }
  MovingBody body_;
  std::vector<double> predicted_, origin_;
};

INSTANTIATE_TEST_SUITE_P(Kinds, TimeInertiaTest, testing::ValuesIn(kinds),
                         [](const auto &each) { return std::string(each.param.name); });

double sum_over_ranks(double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return value;
}

/// a'M b.
double form(const MovingBody &body, const Field &a, const Field &b) {
  const std::vector<double> left = body.local(a), right = body.local(b);
  std::vector<double> product(left.size(), 0);
  body.mass->add_product(1, right.data(), product.data());
  return sum_over_ranks(dot(left, product));
}

/// The integral of rho f over the body by another way: cells in 8^n parts by the midpoint rule.
double integral(const MovingBody &body, const std::function<double(const double *p)> &f) {
  const ReferenceElement &reference =
      reference_element(body.mesh.dimension(), body.mesh.nodes_per_cell());
  constexpr int parts = 12;
  const int dim = reference.dimension;
  double sum = 0;
  for (PetscInt c = 0; c < body.mesh.local_cells(); ++c) {
    const PetscInt *node = &body.mesh.cells[static_cast<std::size_t>(reference.nodes * c)];
    const double density = density_at(centroid_of_cell(body.mesh, static_cast<std::size_t>(c)));
    for (int k = 0; k < parts * parts * (dim == 3 ? parts : 1); ++k) {
      // A cube of which sides are collapsed.
      const double t = dim == 3 ? (k / (parts * parts) + 0.5) / parts : 0,
                   s = (k / parts % parts + 0.5) / parts, r = (k % parts + 0.5) / parts;
      const double at[3] = {r * (1 - s) * (1 - t), s * (1 - t), t};
      const double weight =
          (1 - s) * (1 - t) * (1 - t) / (dim == 3 ? std::pow(parts, 3) : parts * parts);
      double values[ReferenceElement::most_nodes], gradients[ReferenceElement::most_nodes][3];
      shape_functions(dim, reference.nodes, at, values, gradients);
      Matrix3<double> J;
      double p[3] = {};
      for (int i = 0; i < 3; ++i) J(i, i) = i < dim ? 0 : 1;
      for (int a = 0; a < reference.nodes; ++a) {
        for (int i = 0; i < dim; ++i) {
          const double x = body.mesh.coordinates[static_cast<std::size_t>(3 * node[a] + i)];
          p[i] += values[a] * x;
          for (int j = 0; j < dim; ++j) J(i, j) += x * gradients[a][j];
        }
      }
      sum += density * weight * determinant(J) * f(p);
    }
  }
  return sum_over_ranks(sum);
}

TEST_P(TimeInertiaTest, MassesIntegrateTheProducts) {
  const auto one = [](const double *, int i) { return i == 0 ? 1. : 0.; };
  const auto x = [](const double *p, int i) { return i == 0 ? p[0] : 0.; };
  const auto y = [](const double *p, int i) { return i == 0 ? p[1] : 0.; };
  EXPECT_NEAR(form(body_, one, one) / integral(body_, [](const double *) { return 1; }), 1, 4e-3);
  EXPECT_NEAR(form(body_, one, x) / integral(body_, [](const double *p) { return p[0]; }), 1, 4e-3);
  if (GetParam().mass == MassKind::lumped) return;
  // On bent cells as well: positions are interpolated like displacements.
  EXPECT_NEAR(form(body_, x, y) / integral(body_, [](const double *p) { return p[0] * p[1]; }), 1,
              4e-3);
  if (GetParam().bent) return;
  const double dim = body_.mesh.dimension();
  // Half of the unit cube has density 7, half 3: int rho x y, exactly, by the rows of the mesh.
  if (dim == 3 && GetParam().resolution == 2) {
    EXPECT_NEAR(form(body_, x, y), 0.5 * (7 * 0.125 + 3 * 0.375), 1e-13);
  }
}

TEST_P(TimeInertiaTest, HasItsDerivatives) {
  OwnedVec x, d, g, moved, product;
  OwnedMat H, N;
  TrefoilSplitStatistics statistics{};
  begin_step();
  ASSERT_EQ(body_.vector(small, &x), PETSC_SUCCESS);
  ASSERT_EQ(body_.vector(noise, &d), PETSC_SUCCESS);
  for (Vec *each : {&g, &moved, &product}) ASSERT_EQ(VecDuplicate(x, each), PETSC_SUCCESS);
  ASSERT_EQ(body_.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->hessian(x, H, &N, &statistics), PETSC_SUCCESS);
  const double h = 1e-4;
  PetscScalar slopes[2] = {0, 0}, slope = 0, curvature = 0;
  EnergySums sums[2];
  for (int k = 0; k < 2; ++k) {
    ASSERT_EQ(VecWAXPY(moved, k ? h : -h, d, x), PETSC_SUCCESS);
    ASSERT_EQ(body_.functional->gradient(moved, g), PETSC_SUCCESS);
    ASSERT_EQ(body_.functional->energy(moved, &sums[k]), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(g, d, &slopes[k]), PETSC_SUCCESS);
  }
  ASSERT_EQ(body_.functional->gradient(x, g), PETSC_SUCCESS);
  ASSERT_EQ(VecDot(g, d, &slope), PETSC_SUCCESS);
  ASSERT_EQ(MatMult(H, d, product), PETSC_SUCCESS);
  ASSERT_EQ(VecDot(d, product, &curvature), PETSC_SUCCESS);
  EXPECT_NEAR((sums[1].energy - sums[0].energy) / (2 * h) / slope, 1, 1e-5);
  EXPECT_NEAR((slopes[1] - slopes[0]) / (2 * h) / curvature, 1, 1e-5);

  // In a plane, with both directions at once.
  const Vec directions[2] = {d, x};
  const double coefficients[4] = {0.3, 0, 0.2, -0.4};
  double changes[2];
  EnergySums at_x;
  ASSERT_EQ(body_.functional->energy(x, &at_x), PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->energy_changes(x, 2, directions, 2, coefficients, changes),
            PETSC_SUCCESS);
  for (int k = 0; k < 2; ++k) {
    ASSERT_EQ(VecWAXPY(moved, coefficients[2 * k], d, x), PETSC_SUCCESS);
    ASSERT_EQ(VecAXPY(moved, coefficients[2 * k + 1], x), PETSC_SUCCESS);
    EnergySums there;
    ASSERT_EQ(body_.functional->energy(moved, &there), PETSC_SUCCESS);
    EXPECT_NEAR(changes[k] / (there.energy - at_x.energy), 1, 1e-9);
  }
}

/// f = |u - predicted|_M^2 / (2 s^2) + alpha |u - origin|_M^2 / (2 c), held components as well.
TEST_P(TimeInertiaTest, IsWhatItSaysUpToAConstant) {
  begin_step();
  const auto at = [&](const std::vector<double> &u) {
    EnergySums sums;
    EXPECT_EQ(body_.inertia->add_energy(u.data(), &sums), PETSC_SUCCESS);
    return EnergySums{.energy = sum_over_ranks(sums.energy), .scale = sum_over_ranks(sums.scale)};
  };
  const auto expected = [&](const Field &u) {
    const auto from = [&](const Field &origin) {
      return [u, origin](const double *p, int i) { return u(p, i) - origin(p, i); };
    };
    const auto w = from(predicted_field), v = from(origin_field);
    return EnergySums{.energy = form(body_, w, w) / (2 * step * step) +
                                damping * form(body_, v, v) / (2 * velocity_time),
                      .scale = form(body_, v, v) / (2 * velocity_time * velocity_time)};
  };
  const EnergySums change_of = expected(small), from = expected(at_rest);
  const EnergySums one = at(body_.local(small)), other = at(body_.local(at_rest));
  EXPECT_NEAR((one.energy - other.energy) / (change_of.energy - from.energy), 1, 1e-11);
  EXPECT_NEAR(one.scale / change_of.scale, 1, 1e-11) << "the kinetic energy";
}

/// Whether a symmetric matrix has an eigenvalue below -tolerance.
bool is_indefinite(int n, std::vector<double> A, double tolerance) {
  std::vector<double> N(A.size());
  int negative = 0;
  for (int k = 0; k < n; ++k) A[static_cast<std::size_t>((n + 1) * k)] += tolerance;
  EXPECT_EQ(split(n, 1, A.data(), N.data(), &negative).status, SplitStatus::ok);
  return negative > 0;
}

/// Takes the Hessians K of all elements, and adds their masses.
class WithMass final : public StencilSink {
 public:
  WithMass(const MovingBody &body, double stiffness) : body_(body), stiffness_(stiffness) {}
  PetscErrorCode add(const Stencil &stencil, const double *K) override {
    const int n = stencil.n, dim = body_.mesh.dimension(), nodes = n / dim;
    std::vector<double> A(K, K + n * n), M(static_cast<std::size_t>(nodes * nodes));
    body_.mass->of_cell(stencil.cell, M.data());
    for (int r = 0; r < n; ++r) {
      for (int c = r % dim; c < n; c += dim) {
        A[static_cast<std::size_t>(n * r + c)] +=
            stiffness_ * M[static_cast<std::size_t>(nodes * (r / dim) + c / dim)];
      }
    }
    matrices.push_back(std::move(A));
    dofs.emplace_back(stencil.dofs, stencil.dofs + n);
    return PETSC_SUCCESS;
  }
  PetscErrorCode add_split(const Stencil &, const double *, const double *, int) override {
    return PETSC_ERR_SUP;
  }
  std::vector<std::vector<double>> matrices;
  std::vector<std::vector<PetscInt>> dofs;

 private:
  const MovingBody &body_;
  double stiffness_;
};

/// The negative part that goes into N of each element, by the batched path, in the order of dofs.
std::vector<std::vector<double>> negative_parts(const MovingBody &body, const double *u,
                                                const WithMass &sums) {
  const ElementPacks &packs = body.elements->elements();
  const int nodes = packs.reference->nodes, dim = packs.reference->dimension, n = dim * nodes;
  std::vector<double> K(static_cast<std::size_t>(packs.packs() * packs.entries() * lanes)), N(K);
  std::vector<int> negative(static_cast<std::size_t>(packs.packs() * lanes));
  body.elements->hessians(0, packs.packs(), u, K.data());
  body.inertia->shift_filter(packs, 0, packs.packs(), K.data());
  body.elements->split(0, packs.packs(), u, K.data(), N.data(), negative.data());
  std::vector<std::vector<double>> result;
  std::vector<double> blocks(static_cast<std::size_t>(nodes * (nodes + 1) / 2 * dim * dim * lanes));
  for (std::size_t e = 0; e < static_cast<std::size_t>(packs.elements); ++e) {
    const std::size_t pack = e / lanes, lane = e % lanes;
    body.elements->expand()(N.data() + pack * static_cast<std::size_t>(packs.entries()) * lanes,
                            blocks.data());
    std::vector<double> full(static_cast<std::size_t>(n * n), 0);
    const auto &dofs = sums.dofs[e];
    const auto place = [&](int a) {
      const PetscInt vertex =
          packs.nodes[(static_cast<std::size_t>(nodes) * pack + static_cast<std::size_t>(a)) *
                          lanes +
                      lane];
      int k = 0;
      while (dofs[static_cast<std::size_t>(dim * k)] / 3 != vertex) ++k;
      return dim * k;
    };
    const double *entry = blocks.data() + lane;
    for (int a = 0; a < nodes; ++a) {
      for (int b = a; b < nodes; ++b) {
        for (int k = 0; k < dim * dim; ++k, entry += lanes) {
          const int row = place(a) + k / dim, column = place(b) + k % dim;
          full[static_cast<std::size_t>(n * row + column)] = *entry;
          full[static_cast<std::size_t>(n * column + row)] = *entry;
        }
      }
    }
    result.push_back(std::move(full));
  }
  return result;
}

/// Elements of inertia m and stiffness K get a negative part where, and only where, K + m has a
/// negative eigenvalue; and with it they have none. That is so for all elements, quadratic ones
/// too, whose masses mix with translations.
TEST_P(TimeInertiaTest, TheFilterSeesItExactly) {
  constexpr double inertia_time = 0.36, slowly = 3;  // not stiffer than the body
  const double stiffness = 1 / (inertia_time * inertia_time) + damping / slowly;
  const std::vector<double> u = body_.local(small), zero(u.size(), 0);
  ASSERT_EQ(body_.functional->begin_step({1, step, inertia_time, zero.data(), slowly, zero.data()}),
            PETSC_SUCCESS);
  WithMass sums(body_, stiffness);
  ASSERT_EQ(body_.elastic->add_hessian(u.data(), sums), PETSC_SUCCESS);
  const auto negative = negative_parts(body_, u.data(), sums);
  int indefinite = 0, without_mass = 0;
  WithMass alone(body_, 0);
  ASSERT_EQ(body_.elastic->add_hessian(u.data(), alone), PETSC_SUCCESS);
  for (std::size_t e = 0; e < sums.matrices.size(); ++e) {
    const std::vector<double> &A = sums.matrices[e], &N = negative[e];
    const int n = static_cast<int>(sums.dofs[e].size());
    const double size = std::accumulate(
        A.begin(), A.end(), 0., [](double s, double x) { return std::max(s, std::abs(x)); });
    const double noise_level = 1e-12 * size;
    const bool has_part = std::any_of(N.begin(), N.end(), [](double x) { return x != 0; });
    const bool is_negative = is_indefinite(n, A, noise_level);
    if (is_negative) {
      EXPECT_TRUE(has_part);
    }
    if (!is_indefinite(n, A, -noise_level)) {
      EXPECT_FALSE(has_part);
    }
    std::vector<double> clamped(A);
    for (std::size_t k = 0; k < A.size(); ++k) clamped[k] += N[k];
    EXPECT_FALSE(is_indefinite(n, clamped, noise_level)) << "element " << e;
    if (has_part) {  // and no more than that
      std::vector<double> less(A);
      for (std::size_t k = 0; k < A.size(); ++k) less[k] += 0.999 * N[k];
      EXPECT_TRUE(is_indefinite(n, less, 0)) << "element " << e;
    }
    indefinite += is_negative;
    without_mass += is_indefinite(n, alone.matrices[e], noise_level);
  }
  EXPECT_GT(sum_over_ranks(indefinite), 0);
  EXPECT_LT(sum_over_ranks(indefinite), sum_over_ranks(without_mass));

  // And so it is counted, by the batched path and the slow one.
  for (const bool slow : {false, true}) {
    OwnedVec x;
    OwnedMat H, N;
    TrefoilSplitStatistics statistics{};
    SNES snes = nullptr;
    ASSERT_EQ(body_.vector(small, &x), PETSC_SUCCESS);
    ASSERT_EQ(body_.discretization.create_matrix(&H), PETSC_SUCCESS);
    ASSERT_EQ(SNESCreate(PETSC_COMM_WORLD, &snes), PETSC_SUCCESS);
    ASSERT_EQ(
        body_.functional->attach(
            snes, H, slow ? EnergyFunctional::Assembly::plain : EnergyFunctional::Assembly::split),
        PETSC_SUCCESS);
    ASSERT_EQ(body_.functional->hessian(x, H, &N, &statistics), PETSC_SUCCESS);
    EXPECT_EQ(statistics.indefinite, indefinite);
    ASSERT_EQ(SNESDestroy(&snes), PETSC_SUCCESS);
  }
}

/// By the number of ranks nothing changes.
TEST_P(TimeInertiaTest, ParallelIsSerial) {
  double numbers[2][4];
  for (int k = 0; k < 2; ++k) {
    MovingBody body;
    OwnedVec x, d, g;
    OwnedMat H, N;
    EnergySums sums;
    TrefoilSplitStatistics statistics{};
    PetscScalar slope = 0, curvature = 0;
    ASSERT_EQ(body.set_up(GetParam(), damping, k ? PETSC_COMM_SELF : PETSC_COMM_WORLD),
              PETSC_SUCCESS);
    const std::vector<double> predicted = body.local(predicted_field),
                              origin = body.local(origin_field);
    ASSERT_EQ(body.functional->begin_step(
                  {1, step, step, predicted.data(), velocity_time, origin.data()}),
              PETSC_SUCCESS);
    ASSERT_EQ(body.vector(small, &x), PETSC_SUCCESS);
    ASSERT_EQ(body.vector(noise, &d), PETSC_SUCCESS);
    ASSERT_EQ(VecDuplicate(x, &g), PETSC_SUCCESS);
    ASSERT_EQ(body.discretization.create_matrix(&H), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->energy(x, &sums), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->gradient(x, g), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(g, d, &slope), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->hessian(x, H, &N, &statistics), PETSC_SUCCESS);
    ASSERT_EQ(MatMult(H, d, g), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(g, d, &curvature), PETSC_SUCCESS);
    const double each[4] = {sums.energy, sums.scale, slope, curvature};
    std::copy_n(each, 4, numbers[k]);
  }
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(numbers[0][i] / numbers[1][i], 1, 1e-12) << i;
}

}  // namespace
}  // namespace trefoil::test
