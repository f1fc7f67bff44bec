// Homogeneous deformations: the patch test, forces against P, lateral stretches against closed
// forms. For every element and material. Needs petsc_main.cpp.

#include <gtest/gtest.h>

#include <cmath>

#include "body_problem.hpp"
#include "element/bent_cells.hpp"
#include "manufactured.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil::accuracy {
namespace {

struct Element {
  const char *name;
  int dimension, order;
  bool bent;  ///< midpoints of inner edges off the middle
  ElementPressure pressure = ElementPressure::pointwise;
};
// No bent tet10: its four points integrate cof(J) times a gradient, a cubic, only nearly.
const Element elements[] = {{"tri3", 2, 1, false},
                            {"tri6", 2, 2, false},
                            {"tri6_bent", 2, 2, true},
                            {"tet4", 3, 1, false},
                            {"tet10", 3, 2, false},
                            {"tri6_p0", 2, 2, false, ElementPressure::constant},
                            {"tri6_bent_p0", 2, 2, true, ElementPressure::constant},
                            {"tet10_p0", 3, 2, false, ElementPressure::constant}};

/// A body of unit length whose inner vertices are out of line.
CellList distorted_mesh(const Element &element) {
  CellList mesh = generate_mesh(element.dimension == 2 ? "square" : "box", 3, 0);
  const auto inside = [&](const double *p) {
    bool result = true;
    for (int i = 0; i < mesh.dimension(); ++i) result = result && p[i] > 1e-9 && p[i] < 1 - 1e-9;
    return result;
  };
  const auto shift = [&](std::size_t first, double size) {
    for (std::size_t v = first; 3 * v < mesh.coordinates.size(); ++v)
      for (std::size_t i = 0; inside(&mesh.coordinates[3 * v]) && i < 3; ++i)
        if (static_cast<int>(i) < mesh.dimension())
          mesh.coordinates[3 * v + i] += size * std::sin(91. * static_cast<double>(3 * v + i));
  };
  shift(0, 0.07);
  const std::size_t corners = mesh.coordinates.size() / 3;
  if (element.order == 2) promote_to_quadratic(mesh);
  if (element.bent) shift(corners, 0.03);
  EXPECT_EQ(first_bent_cell(reference_element(mesh.dimension(), mesh.nodes_per_cell()),
                            mesh.coordinates, mesh.cells),
            -1);
  return mesh;
}

/// Every material here is tested; psi needs a stress-free rest state.
std::vector<std::pair<const char *, std::function<std::unique_ptr<MaterialModel>()>>> materials() {
  const auto neo_hookean = [](double poisson) {
    return make_material_model(StableNeoHookean({1, poisson}, StableNeoHookean::Lame::physical));
  };
  return {{"stable_neo_hookean .3", [=] { return neo_hookean(0.3); }},
          {"stable_neo_hookean .495", [=] { return neo_hookean(0.495); }}};
}

bool on_boundary(const double *p, int dimension) {
  bool result = false;
  for (int i = 0; i < dimension; ++i) result = result || p[i] < 1e-9 || p[i] > 1 - 1e-9;
  return result;
}

class AccuracyPatchTest : public testing::TestWithParam<Element> {
 protected:
  const int dim_ = GetParam().dimension;
  const CellList mesh_ = distorted_mesh(GetParam());

  /// The sum of the elements' forces on the vertices of the face with the largest coordinate k.
  [[nodiscard]] std::array<double, 3> face_force(const Problem &problem,
                                                 const std::vector<double> &u, int k) const {
    std::array<double, 3> sum{};
    const std::vector<double> forces = problem.forces(u);
    for (std::size_t v = 0; 3 * v < u.size(); ++v)
      for (std::size_t i = 0; i < 3; ++i)
        if (problem.mesh.coordinates[3 * v + static_cast<std::size_t>(k)] > 1 - 1e-9)
          sum[i] += forces[3 * v + i];
    MPI_Allreduce(MPI_IN_PLACE, sum.data(), 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return sum;
  }
};

/// With the boundary moved by F x the inside follows, however the mesh is distorted.
TEST_P(AccuracyPatchTest, BoundaryOfAHomogeneousDeformation) {
  const double gradients[3][9] = {{1.3, 0.2, 0.1, -0.1, 0.9, 0.15, 0.05, 0.1, 1.1},
                                  {1, 0.4, 0, 0, 1, 0, 0, 0, 1},     // simple shear
                                  {0.7, 0, 0, 0, 0.8, 0, 0, 0, 1}};  // compression
  for (const auto &[name, make] : materials())
    for (const auto &entries : gradients) {
      Matrix3<double> F;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          F(i, j) = i < dim_ && j < dim_ ? entries[3 * i + j] : i == j ? 1 : 0;
      const auto target = [&](const double *p, int i) {
        return F(i, 0) * p[0] + F(i, 1) * p[1] + F(i, 2) * p[2] - p[i];
      };
      Problem problem;
      std::vector<double> u;
      const auto material = make();
      ASSERT_EQ(problem.set_up(
                    mesh_, make(),
                    [&](const double *p, int i) -> std::optional<double> {
                      if (!on_boundary(p, dim_)) return {};
                      return target(p, i);
                    },
                    GetParam().pressure),
                PETSC_SUCCESS);
      ASSERT_EQ(problem.solve(1e-16), PETSC_SUCCESS);
      ASSERT_EQ(problem.displacements(&u), PETSC_SUCCESS);
      for (std::size_t v = 0; 3 * v < u.size(); ++v)
        for (int i = 0; i < dim_; ++i)
          EXPECT_NEAR(u[3 * v + static_cast<std::size_t>(i)],
                      target(&problem.mesh.coordinates[3 * v], i), 1e-7)
              << name;
      EXPECT_NEAR(problem.elastic_energy(u), material->energy_density(less_identity(F)), 1e-9)
          << name;
      const Matrix3<double> P = material->stress(less_identity(F));
      // Virtual work of the forces in a displacement x_j e_i: P_ij, the volume being one.
      const std::vector<double> forces = problem.forces(u);
      for (int i = 0; i < dim_; ++i)
        for (int j = 0; j < dim_; ++j) {
          double sum = 0;
          for (std::size_t v = 0; 3 * v < u.size(); ++v)
            sum += forces[3 * v + static_cast<std::size_t>(i)] *
                   problem.mesh.coordinates[3 * v + static_cast<std::size_t>(j)];
          MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
          EXPECT_NEAR(sum, P(i, j), 1e-6 * (1 + std::abs(P(i, j)))) << name << i << j;
        }
    }
}

/// Held by planes of symmetry, pulled in some directions and free in the others, whose stretch
/// makes P_ii = 0. Bisection on the material's own P finds it.
TEST_P(AccuracyPatchTest, FreeSidesHaveNoStress) {
  struct Pull {
    std::array<double, 3> stretch;  ///< 0: free
  };
  // Uniaxial and, in space, equibiaxial.
  std::vector<Pull> pulls{{{0, 1.5, 1}}, {{0, 0.7, 1}}};
  if (dim_ == 3) pulls = {{{0, 0, 1.5}}, {{1.3, 1.3, 0}}, {{0.8, 0.8, 0}}};
  for (const auto &[name, make] : materials())
    for (const Pull &pull : pulls) {
      const auto material = make();
      const auto deformation = [&](double side) {
        Matrix3<double> F;
        for (int i = 0; i < 3; ++i) {
          const double stretch = pull.stretch[static_cast<std::size_t>(i)];
          F(i, i) = stretch == 0 ? side : stretch;
        }
        return F;
      };
      const int free_side = pull.stretch[0] == 0 ? 0 : 2;
      double low = 0.3, high = 3;
      for (int k = 0; k < 200; ++k) {
        const double middle = 0.5 * (low + high);
        const double P = material->stress(less_identity(deformation(middle)))(free_side, free_side);
        (P < 0 ? low : high) = middle;
      }
      const double side = 0.5 * (low + high);
      Problem problem;
      std::vector<double> u;
      ASSERT_EQ(problem.set_up(
                    mesh_, make(),
                    [&](const double *p, int i) -> std::optional<double> {
                      const double stretch = pull.stretch[static_cast<std::size_t>(i)];
                      if (p[i] < 1e-9) return 0;
                      if (stretch != 0 && p[i] > 1 - 1e-9) return stretch - 1;
                      return {};
                    },
                    GetParam().pressure),
                PETSC_SUCCESS);
      ASSERT_EQ(problem.solve(1e-16), PETSC_SUCCESS);
      ASSERT_EQ(problem.displacements(&u), PETSC_SUCCESS);
      for (std::size_t v = 0; 3 * v < u.size(); ++v)
        for (int i = 0; i < dim_; ++i) {
          const double x = problem.mesh.coordinates[3 * v + static_cast<std::size_t>(i)];
          EXPECT_NEAR(u[3 * v + static_cast<std::size_t>(i)], (deformation(side)(i, i) - 1) * x,
                      1e-6)
              << name;
        }
      EXPECT_NEAR(problem.elastic_energy(u),
                  material->energy_density(less_identity(deformation(side))), 1e-9);
      // The force on a pulled side is P times its area, one.
      const int pulled = pull.stretch[0] == 0 ? dim_ - 1 : 0;
      const double P = material->stress(less_identity(deformation(side)))(pulled, pulled);
      EXPECT_NEAR(face_force(problem, u, pulled)[static_cast<std::size_t>(pulled)], P,
                  1e-6 * (1 + std::abs(P)))
          << name;
    }
}

/// The same by formulas written down by hand, so that material and element are not both wrong.
TEST_P(AccuracyPatchTest, StableNeoHookeanInClosedForm) {
  const StableNeoHookean material({1, 0.4}, StableNeoHookean::Lame::physical);
  const double mu = material.mu(), lambda = material.lambda(), alpha = 1 + mu / lambda, pull = 1.4;
  // P_11 = mu s + lambda (J - alpha) dJ/ds = 0: plane strain J = s pull; uniaxial J = s^2 pull.
  const double s = dim_ == 2 ? lambda * alpha * pull / (mu + lambda * pull * pull)
                             : std::sqrt((alpha - mu / (lambda * pull)) / pull);
  const double J = dim_ == 2 ? s * pull : s * s * pull;
  const double energy = 0.5 * mu * (s * s + (dim_ == 2 ? 1 : s * s) + pull * pull - 3) +
                        0.5 * lambda * (J - alpha) * (J - alpha);
  Problem problem;
  std::vector<double> u;
  ASSERT_EQ(problem.set_up(
                mesh_, make_material_model(material),
                [&](const double *p, int i) -> std::optional<double> {
                  if (p[i] < 1e-9) return 0;
                  if (i == dim_ - 1 && p[i] > 1 - 1e-9) return pull - 1;
                  return {};
                },
                GetParam().pressure),
            PETSC_SUCCESS);
  ASSERT_EQ(problem.solve(1e-16), PETSC_SUCCESS);
  ASSERT_EQ(problem.displacements(&u), PETSC_SUCCESS);
  EXPECT_NEAR(problem.elastic_energy(u) + material.rest_energy_density(), energy, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Elements, AccuracyPatchTest, testing::ValuesIn(elements),
                         [](const auto &each) { return std::string(each.param.name); });

}  // namespace
}  // namespace trefoil::accuracy
