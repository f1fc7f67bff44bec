// A scene of several terms: each Hessian by its own path, into one H and one N. Springs to the
// ground (constant, or as stencils), an energy that is nowhere convex, springs between vertices
// that are no neighbours and change, inertia seen by the filter. Needs petsc_main.cpp.

#include <petscksp.h>

#include "body.hpp"
#include "element/isoparametric_element.hpp"
#include "filter/filter.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil::test {
namespace {

/// Winkler's foundation: k/2 |u_v|^2 at every vertex, by the rank that owns it.
class SpringTerm final : public Term {
 public:
  SpringTerm(const Mesh &mesh, double stiffness, HessianKind kind,
             FilterWeight weight = FilterWeight::rule)
      : mesh_(mesh), stiffness_(stiffness), kind_(kind), weight_(weight) {}

  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override {
    for (std::size_t k = 0; k < mesh_.coordinates.size(); ++k) {
      if (!is_mine(k)) continue;
      sums->energy += 0.5 * stiffness_ * u[k] * u[k];
      sums->scale += 0.5 * std::abs(stiffness_) * u[k] * u[k];
    }
    return PETSC_SUCCESS;
  }
  PetscErrorCode add_gradient(const double *u, double *gradient) const override {
    for (std::size_t k = 0; k < mesh_.coordinates.size(); ++k) {
      if (is_mine(k)) gradient[k] += stiffness_ * u[k];
    }
    return PETSC_SUCCESS;
  }
  [[nodiscard]] HessianKind hessian_kind() const override { return kind_; }
  [[nodiscard]] double hessian_scale() const override { return stiffness_; }
  [[nodiscard]] FilterWeight filter_weight() const override { return weight_; }
  PetscErrorCode add_hessian(const double *, StencilSink &sink) const override {
    const int n = mesh_.dimension();
    const double k = kind_ == HessianKind::constant ? 1 : stiffness_;
    std::vector<double> H(static_cast<std::size_t>(n * n), 0), N(H);
    for (int i = 0; i < n; ++i) {
      H[static_cast<std::size_t>((n + 1) * i)] = k;
      N[static_cast<std::size_t>((n + 1) * i)] = std::max(0., -k);
    }
    PetscFunctionBeginUser;
    ++calls;
    for (PetscInt v = 0; v < mesh_.local_vertices(); ++v) {
      if (!mesh_.owned[static_cast<std::size_t>(v)]) continue;
      const PetscInt dofs[3] = {3 * v, 3 * v + 1, 3 * v + 2};
      const Stencil stencil{.n = n, .dofs = dofs};
      // Every other one knows its negative part.
      PetscCall(v % 2 ? sink.add(stencil, H.data())
                      : sink.add_split(stencil, H.data(), N.data(), k < 0 ? n : 0));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  mutable int calls = 0;

 private:
  [[nodiscard]] bool is_mine(std::size_t dof) const {
    return mesh_.owned[dof / 3] && static_cast<int>(dof % 3) < mesh_.dimension();
  }
  const Mesh &mesh_;
  double stiffness_;
  HessianKind kind_;
  FilterWeight weight_;
};

/// Springs between vertices that share no cell: of the two space diagonals of a box or square that
/// begin at the origin and at the corner next to it, one at a time; accept_step() goes to the
/// other. Every rank knows all displacements; the last one adds the stencil, whoever owns its rows.
class DiagonalSpringTerm final : public Term {
 public:
  DiagonalSpringTerm(const Mesh &mesh, const Discretization &discretization, double stiffness)
      : mesh_(mesh), discretization_(discretization), stiffness_(stiffness) {}

  PetscErrorCode add_energy(const double *u, EnergySums *sums) const override {
    std::array<double, 3> stretch{};
    PetscFunctionBeginUser;
    PetscCall(difference(u, &stretch));
    if (is_last()) {
      for (const double s : stretch) sums->energy += 0.5 * stiffness_ * s * s;
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscErrorCode add_gradient(const double *u, double *gradient) const override {
    std::array<double, 3> stretch{};
    PetscFunctionBeginUser;
    PetscCall(difference(u, &stretch));
    for (int end = 0; end < 2; ++end) {
      const PetscInt v = local_vertex(end);
      for (std::size_t i = 0; v >= 0 && i < 3; ++i) {
        gradient[static_cast<std::size_t>(3 * v) + i] += (end ? -1 : 1) * stiffness_ * stretch[i];
      }
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::stencils; }
  PetscErrorCode add_hessian(const double *, StencilSink &sink) const override {
    const int dim = mesh_.dimension(), n = 2 * dim;
    std::array<PetscInt, 6> dofs{};
    std::vector<double> H(static_cast<std::size_t>(n * n), 0);
    PetscFunctionBeginUser;
    for (int end = 0; end < 2; ++end) {
      std::array<PetscInt, 3> mine{-2, -2, -2};
      if (local_vertex(end) >= 0) mine = discretization_.dofs_of_vertex(local_vertex(end));
      PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, mine.data(), 3, MPIU_INT, MPI_MAX, comm()));
      std::copy_n(mine.begin(), dim, dofs.begin() + dim * end);
    }
    for (int i = 0; i < n; ++i) {
      H[static_cast<std::size_t>(n * i + i)] = stiffness_;
      H[static_cast<std::size_t>(n * i + (i + dim) % n)] = -stiffness_;
    }
    if (is_last()) PetscCall(sink.add({.n = n, .dofs = dofs.data(), .global = true}, H.data()));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  [[nodiscard]] bool couples_pairs() const override { return true; }
  PetscErrorCode choose_pairs(const double *, bool *changed) override {
    *changed = chosen_ != diagonal_;
    chosen_ = diagonal_;
    return PETSC_SUCCESS;
  }
  void append_pairs(VertexPairs *pairs) const override {
    PetscInt ends[2];
    for (int end = 0; end < 2; ++end) {
      const PetscInt v = local_vertex(end);
      ends[end] = v < 0 ? -1 : mesh_.global_vertex[static_cast<std::size_t>(v)];
      MPI_Allreduce(MPI_IN_PLACE, &ends[end], 1, MPIU_INT, MPI_MAX, comm());
    }
    if (!is_last()) return;
    pairs->first.push_back(ends[0]);
    pairs->second.push_back(ends[1]);
  }
  PetscErrorCode accept_step(const double *) override {
    diagonal_ = 1 - diagonal_;
    return PETSC_SUCCESS;
  }
  /// Longer steps than one half of a stretch are not allowed; each rank knows of other steps.
  [[nodiscard]] bool limits_step() const override { return true; }
  PetscErrorCode limit_step(const double *, const double *, double first,
                            double *largest) const override {
    EXPECT_EQ(first, 1);
    *largest = std::min(*largest, is_last() ? 0.25 : 0.5);
    return PETSC_SUCCESS;
  }

  /// The owned vertex at an end of the diagonal; -1: another rank's.
  [[nodiscard]] PetscInt local_vertex(int end) const {
    const double from[3] = {diagonal_ == 0 ? 0. : 1., 0, 0};
    for (PetscInt v = 0; v < mesh_.local_vertices(); ++v) {
      if (!mesh_.owned[static_cast<std::size_t>(v)]) continue;
      bool here = true;
      for (int i = 0; i < mesh_.dimension(); ++i) {
        const double wanted = end ? 1 - from[i] : from[i];
        here = here &&
               std::abs(mesh_.coordinates[static_cast<std::size_t>(3 * v + i)] - wanted) < 1e-9;
      }
      if (here) return v;
    }
    return -1;
  }
  /// u at the first end less u at the second.
  PetscErrorCode difference(const double *u, std::array<double, 3> *result) const {
    PetscFunctionBeginUser;
    for (int end = 0; end < 2; ++end) {
      const PetscInt v = local_vertex(end);
      for (std::size_t i = 0; v >= 0 && i < 3; ++i) {
        (*result)[i] += (end ? -1 : 1) * u[static_cast<std::size_t>(3 * v) + i];
      }
    }
    PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, result->data(), 3, MPI_DOUBLE, MPI_SUM, comm()));
    PetscFunctionReturn(PETSC_SUCCESS);
  }

 private:
  [[nodiscard]] MPI_Comm comm() const {
    return PetscObjectComm(reinterpret_cast<PetscObject>(mesh_.dm));
  }
  [[nodiscard]] bool is_last() const {
    PetscMPIInt rank = 0, ranks = 0;
    MPI_Comm_rank(comm(), &rank);
    MPI_Comm_size(comm(), &ranks);
    return rank + 1 == ranks;
  }
  const Mesh &mesh_;
  const Discretization &discretization_;
  double stiffness_;
  int diagonal_ = 0, chosen_ = -1;
};

/// The consistent mass matrix of linear cells, times a number: V/20 (1 + delta_ab) in space, A/12
/// (1 + delta_ab) in the plane. The filter sees it.
class MassTerm final : public Term {
 public:
  MassTerm(const Mesh &mesh, double scale)
      : mesh_(mesh), scale_(scale), nodes_(mesh.nodes_per_cell()) {
    for (PetscInt c = 0; c < mesh.local_cells(); ++c) {
      double positions[12];
      for (int a = 0; a < nodes_; ++a) {
        const auto v = static_cast<std::size_t>(node(c, a));
        std::copy_n(&mesh.coordinates[3 * v], 3, positions + 3 * a);
      }
      const IsoparametricElement element(reference_element(mesh.dimension(), nodes_), positions);
      sigma_.push_back(element.weight(0) / (nodes_ * (nodes_ + 1)));
    }
  }
  [[nodiscard]] PetscInt node(PetscInt cell, int a) const {
    return mesh_.cells[static_cast<std::size_t>(nodes_ * cell + a)];
  }
  [[nodiscard]] double sigma(PetscInt cell) const {
    return scale_ * sigma_[static_cast<std::size_t>(cell)];
  }
  PetscErrorCode add_energy(const double *, EnergySums *) const override { return PETSC_SUCCESS; }
  PetscErrorCode add_gradient(const double *, double *) const override { return PETSC_SUCCESS; }
  [[nodiscard]] HessianKind hessian_kind() const override { return HessianKind::constant; }
  [[nodiscard]] double hessian_scale() const override { return scale_; }
  PetscErrorCode add_hessian(const double *, StencilSink &sink) const override {
    const int dim = mesh_.dimension(), n = dim * nodes_;
    PetscFunctionBeginUser;
    for (PetscInt c = 0; c < mesh_.local_cells(); ++c) {
      std::vector<double> M(static_cast<std::size_t>(n * n), 0);
      std::vector<PetscInt> dofs;
      for (int k = 0; k < n; ++k) dofs.push_back(3 * node(c, k / dim) + k % dim);
      add_mass(sigma_[static_cast<std::size_t>(c)], M.data());
      PetscCall(sink.add({.n = n, .dofs = dofs.data(), .cell = c}, M.data()));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  void add_mass(double sigma, double *M) const {
    const int dim = mesh_.dimension(), n = dim * nodes_;
    for (int k = 0; k < n; ++k) {
      for (int l = k % dim; l < n; l += dim) M[n * k + l] += k == l ? 2 * sigma : sigma;
    }
  }
  [[nodiscard]] bool shifts_filter() const override { return true; }
  void shift_filter(const ElementPacks &cells, PetscInt first, PetscInt count,
                    double *K) const override {
    for (PetscInt pack = 0; pack < count; ++pack, K += cells.entries() * lanes) {
      for (int row = 0, entry = 0; row < cells.rows(); entry += ++row + 1) {
        for (PetscInt lane = 0; lane < lanes; ++lane) {
          const PetscInt cell = lanes * (first + pack) + lane;
          if (cell < cells.elements) K[lanes * entry + lane] += sigma(cell);
        }
      }
    }
  }

 private:
  const Mesh &mesh_;
  double scale_;
  int nodes_;
  std::vector<double> sigma_;
};

struct Matrices {
  OwnedMat H, N;
  TrefoilSplitStatistics statistics{};
};

/// H + 2 w N times the field, and its product with it: the same on any number of ranks.
double curvature(const Body &body, Mat matrix, const Field &field) {
  OwnedVec x, product;
  PetscScalar result = 0;
  EXPECT_EQ(body.vector(field, &x), PETSC_SUCCESS);
  EXPECT_EQ(VecDuplicate(x, &product), PETSC_SUCCESS);
  EXPECT_EQ(MatMult(matrix, x, product), PETSC_SUCCESS);
  EXPECT_EQ(VecDot(x, product, &result), PETSC_SUCCESS);
  return result;
}

double probe(const double *p, int i) {
  return noise(p, i + 3);
}

/// sum of probe^2 over the free components of the vertices.
double square(const Body &body) {
  OwnedVec x;
  PetscScalar result = 0;
  EXPECT_EQ(body.vector(probe, &x), PETSC_SUCCESS);
  EXPECT_EQ(VecDot(x, x, &result), PETSC_SUCCESS);
  return result;
}

struct Kind {
  const char *name, *mesh;
  PetscInt resolution;
  int order;
  Holding holding;
};
const std::vector<Kind> kinds{{"tri3", "square", 5, 1, nothing},
                              {"tri6", "square", 4, 2, nothing},
                              {"tet4", "box", 3, 1, bottom},
                              {"tet4_components", "box", 3, 1, bottom_and_sides},
                              {"tet10", "box", 2, 2, bottom}};

class SecondTermTest : public testing::TestWithParam<Kind> {
 protected:
  [[nodiscard]] static PetscErrorCode set_up(Body *body, MPI_Comm comm = PETSC_COMM_WORLD) {
    CellList whole = generate_mesh(GetParam().mesh, GetParam().resolution, 0);
    if (GetParam().order == 2) promote_to_quadratic(whole);
    return body->set_up(comm, whole, GetParam().holding, small);
  }
  static double small(const double *p, int i) { return 0.3 * crumpled(p, i); }

  static void assemble(Body &body, Matrices *result, const HessianFilter &filter = {}) {
    OwnedVec x;
    ASSERT_EQ(body.vector(small, &x), PETSC_SUCCESS);
    if (!result->H) {
      ASSERT_EQ(body.discretization.create_matrix(&result->H), PETSC_SUCCESS);
    }
    result->statistics = {};
    ASSERT_EQ(body.functional->hessian(x, result->H, &result->N, &result->statistics, filter),
              PETSC_SUCCESS);
  }
  SpringTerm *add_springs(Body &body, double stiffness, HessianKind kind,
                          FilterWeight weight = FilterWeight::rule) {
    auto term = std::make_unique<SpringTerm>(body.mesh, stiffness, kind, weight);
    SpringTerm *result = term.get();
    body.functional->add_term(std::move(term));
    return result;
  }
};

INSTANTIATE_TEST_SUITE_P(Kinds, SecondTermTest, testing::ValuesIn(kinds),
                         [](const auto &each) { return std::string(each.param.name); });

TEST_P(SecondTermTest, SpringsAddTheirStiffnessByEitherPath) {
  for (const HessianKind kind : {HessianKind::constant, HessianKind::stencils}) {
    Body alone, two;
    Matrices one, both;
    ASSERT_EQ(set_up(&alone), PETSC_SUCCESS);
    ASSERT_EQ(set_up(&two), PETSC_SUCCESS);
    const SpringTerm *springs = add_springs(two, 5, kind);
    for (int repeat = 0; repeat < 2; ++repeat) {
      assemble(alone, &one);
      assemble(two, &both);
    }
    EXPECT_NEAR(curvature(two, both.H, probe) - curvature(alone, one.H, probe), 5 * square(two),
                1e-11 * curvature(two, both.H, probe));
    EXPECT_NEAR(curvature(two, both.N, probe) / curvature(alone, one.N, probe), 1, 1e-12);
    EXPECT_EQ(both.statistics.indefinite, one.statistics.indefinite) << "springs are convex";
    if (kind == HessianKind::constant) {
      EXPECT_EQ(springs->calls, 1) << "a constant matrix is made once";
    }
  }
}

/// f(x + s d) - f(x) of all terms: gradient and H are derivatives.
TEST_P(SecondTermTest, TheSumHasItsDerivatives) {
  Body body;
  OwnedVec x, d, g, moved;
  Matrices all;
  ASSERT_EQ(set_up(&body), PETSC_SUCCESS);
  add_springs(body, 2, HessianKind::constant);
  add_springs(body, -1.5, HessianKind::stencils);
  ASSERT_EQ(body.vector(small, &x), PETSC_SUCCESS);
  ASSERT_EQ(body.vector(probe, &d), PETSC_SUCCESS);
  for (Vec *each : {&g, &moved}) ASSERT_EQ(VecDuplicate(x, each), PETSC_SUCCESS);
  assemble(body, &all);
  const double h = 1e-4;
  PetscScalar slopes[2] = {0, 0};
  for (int k = 0; k < 2; ++k) {
    ASSERT_EQ(VecWAXPY(moved, k ? h : -h, d, x), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->gradient(moved, g), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(g, d, &slopes[k]), PETSC_SUCCESS);
  }
  const double second = curvature(body, all.H, probe);
  EXPECT_NEAR((slopes[1] - slopes[0]) / (2 * h) / second, 1, 1e-5);
  const Vec directions[1] = {d};
  const double coefficients[2] = {h, -h};
  double changes[2];
  ASSERT_EQ(body.functional->energy_changes(x, 1, directions, 2, coefficients, changes),
            PETSC_SUCCESS);
  EXPECT_NEAR((changes[0] + changes[1]) / (h * h) / second, 1, 1e-4);
}

/// Of an energy that is nowhere convex: filtered by the rule's weight, or clamped whatever that is.
TEST_P(SecondTermTest, ATermMayBeClampedWhateverTheRuleSays) {
  for (const double weight : {0.25, 0.5, 1.0}) {
    double filtered[2], size = 0;
    for (const FilterWeight own : {FilterWeight::rule, FilterWeight::clamp}) {
      Body alone, two;
      Matrices one, both;
      ASSERT_EQ(set_up(&alone), PETSC_SUCCESS);
      ASSERT_EQ(set_up(&two), PETSC_SUCCESS);
      add_springs(two, -3, HessianKind::stencils, own);
      assemble(alone, &one, {weight, {}});
      assemble(two, &both, {weight, {}});
      size = square(two);
      const double unfiltered = curvature(two, both.H, probe) - curvature(alone, one.H, probe);
      EXPECT_NEAR(unfiltered, -3 * square(two), 1e-11 * curvature(alone, one.H, probe));
      filtered[own == FilterWeight::clamp] =
          unfiltered +
          2 * weight * (curvature(two, both.N, probe) - curvature(alone, one.N, probe));
      PetscInt64 counts[2] = {both.statistics.indefinite - one.statistics.indefinite,
                              both.statistics.elements - one.statistics.elements};
      EXPECT_EQ(counts[0], counts[1]) << "all springs are indefinite";
    }
    EXPECT_NEAR(filtered[0], (2 * weight - 1) * 3 * size, 1e-10 * size) << weight;
    EXPECT_NEAR(filtered[1], 0, 1e-10 * size) << weight;
  }
}

/// Cells are described as if they were alone.
TEST_P(SecondTermTest, OtherTermsAreNoCells) {
  Body alone, two;
  OwnedVec x;
  EnergyFunctional::CellReport one, both;
  ASSERT_EQ(set_up(&alone), PETSC_SUCCESS);
  ASSERT_EQ(set_up(&two), PETSC_SUCCESS);
  add_springs(two, -3, HessianKind::stencils);
  ASSERT_EQ(alone.vector(small, &x), PETSC_SUCCESS);
  ASSERT_EQ(alone.functional->describe_cells(x, &one), PETSC_SUCCESS);
  ASSERT_EQ(two.functional->describe_cells(x, &both), PETSC_SUCCESS);
  EXPECT_EQ(both.negative_eigenvalues, one.negative_eigenvalues);
  EXPECT_EQ(both.determinant, one.determinant);
  SNES snes = nullptr;  // and so on the slow path
  OwnedMat H;
  ASSERT_EQ(two.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(SNESCreate(PETSC_COMM_WORLD, &snes), PETSC_SUCCESS);
  ASSERT_EQ(two.functional->attach(snes, H, EnergyFunctional::Assembly::plain), PETSC_SUCCESS);
  ASSERT_EQ(two.functional->describe_cells(x, &both), PETSC_SUCCESS);
  EXPECT_EQ(both.negative_eigenvalues, one.negative_eigenvalues);
  ASSERT_EQ(SNESDestroy(&snes), PETSC_SUCCESS);
}

TEST_P(SecondTermTest, ThePatternFollowsPairs) {
  Body alone, two;
  Matrices one, both;
  ASSERT_EQ(set_up(&alone), PETSC_SUCCESS);
  ASSERT_EQ(set_up(&two), PETSC_SUCCESS);
  add_springs(two, 2, HessianKind::constant);
  auto term = std::make_unique<DiagonalSpringTerm>(two.mesh, two.discretization, 7);
  const DiagonalSpringTerm &diagonal = *term;
  two.functional->add_term(std::move(term));
  assemble(alone, &one);
  OwnedVec x, right, solution, left;
  ASSERT_EQ(two.vector(probe, &x), PETSC_SUCCESS);
  for (Vec *each : {&right, &solution, &left}) ASSERT_EQ(VecDuplicate(x, each), PETSC_SUCCESS);
  KSP ksp = nullptr;
  PC pc = nullptr;
  ASSERT_EQ(KSPCreate(PETSC_COMM_WORLD, &ksp), PETSC_SUCCESS);
  ASSERT_EQ(KSPSetType(ksp, KSPPREONLY), PETSC_SUCCESS);
  ASSERT_EQ(KSPGetPC(ksp, &pc), PETSC_SUCCESS);
  ASSERT_EQ(PCSetType(pc, PCLU), PETSC_SUCCESS);
  ASSERT_EQ(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), PETSC_SUCCESS);
  for (int step = 0; step < 3; ++step) {
    assemble(two, &both);
    Vec local = nullptr;
    const PetscScalar *values = nullptr;
    std::array<double, 3> stretch{};
    ASSERT_EQ(two.discretization.get_local_direction(x, &local, &values), PETSC_SUCCESS);
    ASSERT_EQ(diagonal.difference(values, &stretch), PETSC_SUCCESS);
    ASSERT_EQ(two.discretization.restore_local(&local, &values), PETSC_SUCCESS);
    double expected = curvature(alone, one.H, probe) + 2 * square(two);
    for (int i = 0; i < two.mesh.dimension(); ++i)
      expected += 7 * stretch[static_cast<std::size_t>(i)] * stretch[static_cast<std::size_t>(i)];
    EXPECT_NEAR(curvature(two, both.H, probe) / expected, 1, 1e-11) << step;
    EXPECT_NEAR(curvature(two, both.N, probe) / curvature(alone, one.N, probe), 1, 1e-11) << step;
    // N has H's pattern: the plugin adds the two number by number.
    OwnedMat sum;
    ASSERT_EQ(MatDuplicate(both.H, MAT_COPY_VALUES, &sum), PETSC_SUCCESS);
    ASSERT_EQ(MatAXPY(sum, 1, both.N, SAME_NONZERO_PATTERN), PETSC_SUCCESS);
    EXPECT_NEAR(curvature(two, sum, probe) / (expected + curvature(alone, one.N, probe)), 1, 1e-11);
    // A solver that has seen another pattern solves with this one.
    PetscReal error = 0, size = 0;
    ASSERT_EQ(KSPSetOperators(ksp, both.H, both.H), PETSC_SUCCESS);
    ASSERT_EQ(MatMult(both.H, x, right), PETSC_SUCCESS);
    ASSERT_EQ(KSPSolve(ksp, right, solution), PETSC_SUCCESS);
    ASSERT_EQ(MatMult(both.H, solution, left), PETSC_SUCCESS);
    ASSERT_EQ(VecNorm(right, NORM_2, &size), PETSC_SUCCESS);
    ASSERT_EQ(VecAXPY(left, -1, right), PETSC_SUCCESS);
    ASSERT_EQ(VecNorm(left, NORM_2, &error), PETSC_SUCCESS);
    EXPECT_LT(error, 1e-9 * size) << step;
    PetscBool symmetric = PETSC_FALSE, known = PETSC_FALSE;
    ASSERT_EQ(MatIsSymmetricKnown(both.H, &known, &symmetric), PETSC_SUCCESS);
    EXPECT_TRUE(known && symmetric);
    ASSERT_EQ(two.functional->accept_step(x), PETSC_SUCCESS);
  }
  ASSERT_EQ(KSPDestroy(&ksp), PETSC_SUCCESS);
}

TEST_P(SecondTermTest, TheShortestStepOfAllRanksCounts) {
  Body body;
  OwnedVec x;
  double largest = 0;
  ASSERT_EQ(set_up(&body), PETSC_SUCCESS);
  ASSERT_EQ(body.vector(small, &x), PETSC_SUCCESS);
  ASSERT_EQ(body.functional->largest_step(x, x, 1, &largest), PETSC_SUCCESS);
  EXPECT_EQ(largest, 1);
  body.functional->add_term(
      std::make_unique<DiagonalSpringTerm>(body.mesh, body.discretization, 7));
  ASSERT_EQ(body.functional->largest_step(x, x, 1, &largest), PETSC_SUCCESS);
  EXPECT_EQ(largest, 0.25);
}

/// Takes the matrices of elements with their masses added, and sums up the curvature of their
/// negative parts along `probe`.
class NegativeWithMass final : public StencilSink {
 public:
  NegativeWithMass(const Body &body, const MassTerm &mass) : body_(body), mass_(mass) {}
  PetscErrorCode add(const Stencil &stencil, const double *H) override {
    const int n = stencil.n;
    std::vector<double> sum(H, H + n * n), N(sum.size()), direction;
    int negative = 0;
    mass_.add_mass(mass_.sigma(stencil.cell), sum.data());
    EXPECT_EQ(split(n, 1, sum.data(), N.data(), &negative).status, SplitStatus::ok);
    for (int k = 0; k < n; ++k) {
      const PetscInt dof = stencil.dofs[k];
      const bool free = body_.discretization.global_dofs()[static_cast<std::size_t>(dof)] >= 0;
      direction.push_back(
          free ? probe(&body_.mesh.coordinates[static_cast<std::size_t>(dof - dof % 3)], dof % 3)
               : 0);
    }
    for (std::size_t i = 0; i < direction.size(); ++i)
      for (std::size_t j = 0; j < direction.size(); ++j)
        curvature += direction[i] * N[direction.size() * i + j] * direction[j];
    indefinite += negative > 0;
    return PETSC_SUCCESS;
  }
  PetscErrorCode add_split(const Stencil &, const double *, const double *, int) override {
    return PETSC_ERR_SUP;
  }
  double curvature = 0;
  PetscInt64 indefinite = 0;

 private:
  const Body &body_;
  const MassTerm &mass_;
};

TEST_P(SecondTermTest, TheFilterSeesInertia) {
  if (GetParam().order == 2) GTEST_SKIP() << "their mass mixes with translations";
  Body alone, two;
  Matrices one, both, slow;
  ASSERT_EQ(set_up(&alone), PETSC_SUCCESS);
  ASSERT_EQ(set_up(&two), PETSC_SUCCESS);
  assemble(alone, &one);
  auto term = std::make_unique<MassTerm>(two.mesh, 300);
  NegativeWithMass expected(two, *term);
  two.functional->add_term(std::move(term));
  assemble(two, &both);
  const ElasticTerm elastic(two.mesh, make_material_model(soft_material()), FilterSpace::element);
  Vec local = nullptr;
  OwnedVec x;
  const PetscScalar *u = nullptr;
  ASSERT_EQ(two.vector(small, &x), PETSC_SUCCESS);
  ASSERT_EQ(two.discretization.get_local(x, &local, &u), PETSC_SUCCESS);
  ASSERT_EQ(elastic.add_hessian(u, expected), PETSC_SUCCESS);
  ASSERT_EQ(two.discretization.restore_local(&local, &u), PETSC_SUCCESS);
  EXPECT_EQ(both.statistics.indefinite, expected.indefinite);
  MPI_Allreduce(MPI_IN_PLACE, &expected.curvature, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_NEAR(curvature(two, both.N, probe) / expected.curvature, 1, 1e-11);
  EXPECT_LT(curvature(two, both.N, probe), 0.9 * curvature(alone, one.N, probe));
  SNES snes = nullptr;
  ASSERT_EQ(two.discretization.create_matrix(&slow.H), PETSC_SUCCESS);
  ASSERT_EQ(SNESCreate(PETSC_COMM_WORLD, &snes), PETSC_SUCCESS);
  ASSERT_EQ(two.functional->attach(snes, slow.H, EnergyFunctional::Assembly::plain), PETSC_SUCCESS);
  assemble(two, &slow);
  EXPECT_NEAR(curvature(two, slow.N, probe) / expected.curvature, 1, 1e-11);
  EXPECT_NEAR(curvature(two, slow.H, probe) / curvature(two, both.H, probe), 1, 1e-12);
  EXPECT_EQ(slow.statistics.indefinite, expected.indefinite);
  ASSERT_EQ(SNESDestroy(&snes), PETSC_SUCCESS);
}

/// All at once, whatever the number of ranks.
TEST_P(SecondTermTest, ParallelIsSerial) {
  double numbers[2][3];
  const MPI_Comm comms[2] = {PETSC_COMM_WORLD, PETSC_COMM_SELF};
  for (int k = 0; k < 2; ++k) {
    Body body;
    Matrices all;
    OwnedVec x;
    EnergySums sums;
    ASSERT_EQ(set_up(&body, comms[k]), PETSC_SUCCESS);
    add_springs(body, 2, HessianKind::constant);
    add_springs(body, -1.5, HessianKind::stencils);
    body.functional->add_term(
        std::make_unique<DiagonalSpringTerm>(body.mesh, body.discretization, 7));
    ASSERT_EQ(body.vector(small, &x), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->energy(x, &sums), PETSC_SUCCESS);
    assemble(body, &all);
    numbers[k][0] = sums.energy;
    numbers[k][1] = curvature(body, all.H, probe);
    numbers[k][2] = curvature(body, all.N, probe);
  }
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(numbers[0][i] / numbers[1][i], 1, 1e-12) << i;
}

}  // namespace
}  // namespace trefoil::test
