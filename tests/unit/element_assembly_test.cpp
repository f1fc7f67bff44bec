// Triangles and quadratic elements on meshes, with pressures of their own too: energy, gradient, H
// and N as derivatives of each other, the batched path as the plain one, and the same on every
// number of ranks. Needs petsc_main.cpp.

#include "body.hpp"
#include "matrix3_support.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil::test {
namespace {

struct ElementScene {
  const char *name, *mesh;
  PetscInt resolution;
  int order;
  bool bent;  ///< midpoints of edges off the middle
  Holding holding;
  FilterSpace space;
  ElementPressure pressure = ElementPressure::pointwise;

  friend std::ostream &operator<<(std::ostream &stream, const ElementScene &scene) {
    return stream << scene.name;
  }
};

bool left(const double *p, int) {
  return p[0] < 1e-9;
}
bool left_and_one_component_of_the_right(const double *p, int i) {
  return p[0] < 1e-9 || (i == 0 && p[0] > 1 - 1e-9);
}

const std::vector<ElementScene> element_scenes{
    {"tri3", "square", 6, 1, false, left, FilterSpace::element},
    {"tri3_free", "square", 5, 1, false, nothing, FilterSpace::element},
    {"tri3_components", "square", 5, 1, false, left_and_one_component_of_the_right,
     FilterSpace::element},
    {"tri3_deformation", "square", 6, 1, false, left, FilterSpace::deformation},
    {"tri6", "square", 4, 2, false, left, FilterSpace::element},
    {"tri6_bent_deformation", "square", 4, 2, true, left, FilterSpace::deformation},
    {"tet4_deformation", "box", 3, 1, false, bottom, FilterSpace::deformation},
    {"tet10", "box", 2, 2, false, bottom, FilterSpace::element},
    {"tet10_bent", "box", 2, 2, true, bottom, FilterSpace::element},
    {"tet10_components", "box", 2, 2, false, bottom_and_sides, FilterSpace::element},
    {"tet10_deformation", "box", 2, 2, true, nothing, FilterSpace::deformation},
    {"tri6_p0", "square", 4, 2, false, left, FilterSpace::element, ElementPressure::constant},
    {"tri6_bent_p0", "square", 4, 2, true, nothing, FilterSpace::element,
     ElementPressure::constant},
    {"tet10_p0", "box", 2, 2, false, bottom, FilterSpace::element, ElementPressure::constant},
    {"tet10_components_p0", "box", 2, 2, true, bottom_and_sides, FilterSpace::element,
     ElementPressure::constant}};

CellList make_mesh(const ElementScene &scene) {
  CellList mesh = generate_mesh(scene.mesh, scene.resolution, 0);
  const auto corners = static_cast<std::size_t>(mesh.vertices());
  if (scene.order == 2) promote_to_quadratic(mesh);
  for (std::size_t k = 3 * corners; scene.bent && k < mesh.coordinates.size(); ++k) {
    if (static_cast<int>(k % 3) == mesh.dimension()) continue;
    mesh.coordinates[k] += 0.02 * std::sin(37. * static_cast<double>(k));
  }
  return mesh;
}

/// As `crumpled`, smaller: noise at midpoints counts twice.
double wavy(const double *p, int i) {
  return 0.1 * p[0] * p[(i + 1) % 3] + 0.06 * noise(p, i);
}

class ElementSceneTest : public testing::TestWithParam<ElementScene> {
 protected:
  [[nodiscard]] PetscErrorCode set_up(MPI_Comm comm, Body *body) const {
    return body->set_up(comm, make_mesh(GetParam()), GetParam().holding, wavy, GetParam().space,
                        GetParam().pressure);
  }
};

INSTANTIATE_TEST_SUITE_P(Scenes, ElementSceneTest, testing::ValuesIn(element_scenes),
                         [](const auto &each) { return std::string(each.param.name); });

TEST_P(ElementSceneTest, MeshKnowsItsElement) {
  const CellList whole = make_mesh(GetParam());
  Body body;
  ASSERT_EQ(set_up(PETSC_COMM_WORLD, &body), PETSC_SUCCESS);
  const Mesh &mesh = body.mesh;
  EXPECT_EQ(mesh.dimension(), whole.dimension());
  EXPECT_EQ(mesh.nodes_per_cell(), whole.nodes_per_cell());
  EXPECT_EQ(mesh.element_name(),
            std::string(GetParam().name).substr(0, mesh.element_name().size()));
  EXPECT_EQ(mesh.total_vertices, whole.vertices());
  EXPECT_EQ(mesh.total_cells, whole.size());
  const PetscInt n = GetParam().resolution + 1;
  EXPECT_EQ(mesh.total_corners, mesh.dimension() == 2 ? n * n : n * n * n);
  PetscInt free_components = 0;
  for (PetscInt v = 0; v < whole.vertices(); ++v)
    for (int i = 0; i < whole.dimension(); ++i)
      free_components +=
          !GetParam().holding(&whole.coordinates[static_cast<std::size_t>(3 * v)], i);
  EXPECT_EQ(body.discretization.total_dofs(), free_components);
  const bool whole_blocks = std::string(GetParam().name).find("components") == std::string::npos;
  EXPECT_EQ(body.discretization.block_size(), whole_blocks ? whole.dimension() : 1);
}

TEST_P(ElementSceneTest, GradientAndHessianAreDerivatives) {
  Body body;
  ASSERT_EQ(set_up(PETSC_COMM_WORLD, &body), PETSC_SUCCESS);
  OwnedVec x, direction, g, moved, product;
  OwnedMat H;
  ASSERT_EQ(body.vector(wavy, &x), PETSC_SUCCESS);
  ASSERT_EQ(body.vector([](const double *p, int i) { return noise(p, i + 3); }, &direction),
            PETSC_SUCCESS);
  for (Vec *each : {&g, &moved, &product}) ASSERT_EQ(VecDuplicate(x, each), PETSC_SUCCESS);
  PetscScalar slope = 0;
  PetscReal gradient_norm = 0, direction_norm = 0, size = 0, error = 0;
  ASSERT_EQ(body.functional->gradient(x, g), PETSC_SUCCESS);
  ASSERT_EQ(VecDot(g, direction, &slope), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(g, NORM_2, &gradient_norm), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(direction, NORM_2, &direction_norm), PETSC_SUCCESS);
  const double h = 1e-4;
  const double difference = derivative(h, [&](double s) {
    EnergySums sums;
    EXPECT_EQ(VecWAXPY(moved, s, direction, x), PETSC_SUCCESS);
    EXPECT_EQ(body.functional->energy(moved, &sums), PETSC_SUCCESS);
    return sums.energy;
  });
  EXPECT_NEAR(difference, slope, 1e-8 * gradient_norm * direction_norm);
  TrefoilSplitStatistics statistics{};
  ASSERT_EQ(body.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(body.functional->hessian(x, H, nullptr, &statistics), PETSC_SUCCESS);
  ASSERT_EQ(MatMult(H, direction, product), PETSC_SUCCESS);
  ASSERT_EQ(VecNorm(product, NORM_2, &size), PETSC_SUCCESS);
  const std::pair<double, double> points[] = {{h, 8}, {-h, -8}, {2 * h, -1}, {-2 * h, 1}};
  for (const auto &[s, factor] : points) {
    ASSERT_EQ(VecWAXPY(moved, s, direction, x), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->gradient(moved, g), PETSC_SUCCESS);
    ASSERT_EQ(VecAXPY(product, -factor / (12 * h), g), PETSC_SUCCESS);
  }
  ASSERT_EQ(VecNorm(product, NORM_2, &error), PETSC_SUCCESS);
  EXPECT_LT(error, 1e-8 * size);
}

/// || A - B || / || B ||, Frobenius.
double relative_difference(Mat A, Mat B) {
  OwnedMat difference;
  PetscReal norm = 0, error = 0;
  EXPECT_EQ(MatDuplicate(A, MAT_COPY_VALUES, &difference), PETSC_SUCCESS);
  EXPECT_EQ(MatAXPY(difference, -1, B, SAME_NONZERO_PATTERN), PETSC_SUCCESS);
  EXPECT_EQ(MatNorm(difference, NORM_FROBENIUS, &error), PETSC_SUCCESS);
  EXPECT_EQ(MatNorm(B, NORM_FROBENIUS, &norm), PETSC_SUCCESS);
  return error / norm;
}

TEST_P(ElementSceneTest, BatchedIsPlain) {
  Body batched, plain;
  OwnedVec x;
  OwnedMat H[2], N[2];
  TrefoilSplitStatistics statistics[2]{};
  SNES snes = nullptr;
  ASSERT_EQ(set_up(PETSC_COMM_WORLD, &batched), PETSC_SUCCESS);
  ASSERT_EQ(set_up(PETSC_COMM_WORLD, &plain), PETSC_SUCCESS);
  ASSERT_EQ(batched.vector(wavy, &x), PETSC_SUCCESS);
  ASSERT_EQ(batched.discretization.create_matrix(&H[0]), PETSC_SUCCESS);
  ASSERT_EQ(plain.discretization.create_matrix(&H[1]), PETSC_SUCCESS);
  ASSERT_EQ(SNESCreate(PETSC_COMM_WORLD, &snes), PETSC_SUCCESS);
  ASSERT_EQ(plain.functional->attach(snes, H[1], EnergyFunctional::Assembly::plain), PETSC_SUCCESS);
  ASSERT_EQ(batched.functional->hessian(x, H[0], &N[0], &statistics[0]), PETSC_SUCCESS);
  ASSERT_EQ(plain.functional->hessian(x, H[1], &N[1], &statistics[1]), PETSC_SUCCESS);
  EXPECT_EQ(statistics[0].elements, statistics[1].elements);
  EXPECT_EQ(statistics[0].indefinite, statistics[1].indefinite);
  EXPECT_LT(relative_difference(H[0], H[1]), 1e-12);
  EXPECT_LT(relative_difference(N[0], N[1]), 1e-12);
  EnergyFunctional::CellReport cells[2];
  ASSERT_EQ(batched.functional->describe_cells(x, &cells[0]), PETSC_SUCCESS);
  ASSERT_EQ(plain.functional->describe_cells(x, &cells[1]), PETSC_SUCCESS);
  EXPECT_EQ(cells[0].negative_eigenvalues, cells[1].negative_eigenvalues);
  ASSERT_EQ(SNESDestroy(&snes), PETSC_SUCCESS);
}

/// H + 2 w N is positive semi-definite for w = 1/2 whatever is split, up to rounding.
TEST_P(ElementSceneTest, ClampedHessianHasNoNegativeCurvature) {
  Body body;
  OwnedVec x, direction, product;
  OwnedMat H, N;
  TrefoilSplitStatistics statistics{};
  ASSERT_EQ(set_up(PETSC_COMM_WORLD, &body), PETSC_SUCCESS);
  // Compressed, so that H itself is indefinite.
  ASSERT_EQ(body.vector([](const double *p, int i) { return wavy(p, i) - 0.5 * p[i]; }, &x),
            PETSC_SUCCESS);
  ASSERT_EQ(body.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(body.functional->hessian(x, H, &N, &statistics), PETSC_SUCCESS);
  PetscInt64 indefinite = statistics.indefinite;
  MPI_Allreduce(MPI_IN_PLACE, &indefinite, 1, MPIU_INT64, MPI_SUM, PETSC_COMM_WORLD);
  EXPECT_GT(indefinite, 0);
  bool was_negative = false;
  PetscReal size = 0;
  ASSERT_EQ(MatNorm(H, NORM_FROBENIUS, &size), PETSC_SUCCESS);
  for (int k = 0; k < 20; ++k) {
    PetscScalar before = 0, after = 0, square = 0;
    OwnedVec u, Hu, Nu;
    ASSERT_EQ(body.vector([&](const double *p, int i) { return noise(p, i + 5 * k); }, &u),
              PETSC_SUCCESS);
    ASSERT_EQ(VecDuplicate(u, &Hu), PETSC_SUCCESS);
    ASSERT_EQ(VecDuplicate(u, &Nu), PETSC_SUCCESS);
    // A step against the stiff directions, so that negative curvature shows.
    for (int step = 0; step < 300; ++step) {
      ASSERT_EQ(MatMult(H, u, Hu), PETSC_SUCCESS);
      ASSERT_EQ(VecAXPY(u, -2 / size, Hu), PETSC_SUCCESS);
    }
    ASSERT_EQ(MatMult(H, u, Hu), PETSC_SUCCESS);
    ASSERT_EQ(MatMult(N, u, Nu), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(u, Hu, &before), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(u, Nu, &after), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(u, u, &square), PETSC_SUCCESS);
    was_negative = was_negative || before < 0;
    EXPECT_GE(before + after, -1e-12 * size * square);
    EXPECT_GE(after, -1e-12 * size * square);
  }
  EXPECT_TRUE(was_negative) << "the test saw no negative curvature of H";
}

/// What must not depend on the number of ranks.
struct Numbers {
  double energy = 0, gradient = 0, hessian = 0, negative = 0, product = 0;
  PetscInt64 inverted = 0;
};

TEST_P(ElementSceneTest, ParallelIsSerial) {
  Numbers numbers[2];
  const MPI_Comm comms[2] = {PETSC_COMM_WORLD, PETSC_COMM_SELF};
  for (int k = 0; k < 2; ++k) {
    Body body;
    OwnedVec x, g, u, Hu;
    OwnedMat H, N;
    EnergySums sums;
    TrefoilSplitStatistics statistics{};
    PetscScalar product = 0;
    ASSERT_EQ(set_up(comms[k], &body), PETSC_SUCCESS);
    ASSERT_EQ(body.vector(wavy, &x), PETSC_SUCCESS);
    ASSERT_EQ(body.vector([](const double *p, int i) { return noise(p, i + 3); }, &u),
              PETSC_SUCCESS);
    ASSERT_EQ(VecDuplicate(x, &g), PETSC_SUCCESS);
    ASSERT_EQ(VecDuplicate(x, &Hu), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->energy(x, &sums), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->gradient(x, g), PETSC_SUCCESS);
    ASSERT_EQ(body.discretization.create_matrix(&H), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->hessian(x, H, &N, &statistics), PETSC_SUCCESS);
    ASSERT_EQ(body.functional->count_inverted(x, &numbers[k].inverted), PETSC_SUCCESS);
    ASSERT_EQ(VecNorm(g, NORM_2, &numbers[k].gradient), PETSC_SUCCESS);
    ASSERT_EQ(MatNorm(H, NORM_FROBENIUS, &numbers[k].hessian), PETSC_SUCCESS);
    ASSERT_EQ(MatNorm(N, NORM_FROBENIUS, &numbers[k].negative), PETSC_SUCCESS);
    ASSERT_EQ(MatAXPY(H, 1, N, SAME_NONZERO_PATTERN), PETSC_SUCCESS);
    ASSERT_EQ(MatMult(H, u, Hu), PETSC_SUCCESS);
    ASSERT_EQ(VecDot(u, Hu, &product), PETSC_SUCCESS);
    numbers[k].energy = sums.energy;
    numbers[k].product = product;
  }
  EXPECT_NEAR(numbers[0].energy / numbers[1].energy, 1, 1e-12);
  EXPECT_NEAR(numbers[0].gradient / numbers[1].gradient, 1, 1e-12);
  EXPECT_NEAR(numbers[0].hessian / numbers[1].hessian, 1, 1e-12);
  EXPECT_NEAR(numbers[0].negative / numbers[1].negative, 1, 1e-12);
  EXPECT_NEAR(numbers[0].product / numbers[1].product, 1, 1e-12);
  EXPECT_EQ(numbers[0].inverted, numbers[1].inverted);
}

TEST_P(ElementSceneTest, RigidModesAreAttached) {
  Body body;
  OwnedMat H;
  MatNullSpace space = nullptr;
  PetscInt count = 0;
  ASSERT_EQ(set_up(PETSC_COMM_WORLD, &body), PETSC_SUCCESS);
  ASSERT_EQ(body.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(MatGetNearNullSpace(H, &space), PETSC_SUCCESS);
  ASSERT_NE(space, nullptr);
  ASSERT_EQ(MatNullSpaceGetVecs(space, nullptr, &count, nullptr), PETSC_SUCCESS);
  EXPECT_EQ(count, body.mesh.dimension() == 2 ? 3 : 6);
}

}  // namespace
}  // namespace trefoil::test
