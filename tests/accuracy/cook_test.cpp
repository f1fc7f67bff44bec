// Cook's membrane in plane strain, the work of its loads, and Rivlin's torsion of a cylinder. Needs
// petsc_main.cpp.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "body_problem.hpp"
#include "element/bent_cells.hpp"
#include "manufactured.hpp"
#include "material/stable_neo_hookean.hpp"
#include "mesh/generate.hpp"
#include "mesh/quadratic.hpp"

namespace trefoil::accuracy {
namespace {

/// psi = kappa/4 (J^2 - 1 - 2 ln J) + mu/2 (J^(-2/3) F:F - 3): the energy of deal.II's code
/// gallery, "Quasi-static finite-strain compressible elasticity".
class GalleryNeoHookean {
 public:
  GalleryNeoHookean(double mu, double poisson)
      : mu_(mu), kappa_(2 * mu * (1 + poisson) / (3 * (1 - 2 * poisson))) {}

  template <class Real>
  Real energy_density(const Deformation<Real> &deformation) const {
    const Real J = deformation.J(), root = 1.0 / cbrt(J);
    return 0.25 * kappa_ * (J * J - 1.0 - 2.0 * log(J)) +
           0.5 * mu_ * (root * root * squared_norm(deformation.F()) - 3.0);
  }
  /// P = kappa/2 (J - 1/J) C + mu J^(-2/3) (F - I1/(3 J) C),  C = cof F.
  template <class Real>
  Matrix3<Real> stress(const Deformation<Real> &deformation) const {
    const Matrix3<Real> F = deformation.F();
    const Parts<Real> p(*this, F);
    Matrix3<Real> P;
    for (std::size_t k = 0; k < 9; ++k)
      P.entries[k] =
          p.pressure * p.C.entries[k] + p.shear * (F.entries[k] - p.share * p.C.entries[k]);
    return P;
  }
  /// With m = mu J^(-2/3) and s = I1/(3 J): dP = (kappa/2)(1 + 1/J^2) C C' + (pressure - m s) dC/dF
  /// + m I - (2 m/(3 J)) (F C' + C F') + (5/3 m s / J) C C'.
  template <class Real>
  void tangent(const Deformation<Real> &deformation, Tangent<Real> &A) const {
    const Matrix3<Real> F = deformation.F();
    const Parts<Real> p(*this, F);
    const Real volume =
        0.5 * kappa_ * (1.0 + p.inverse * p.inverse) + (5. / 3) * p.shear * p.share * p.inverse;
    const Real mixed = (2. / 3) * p.shear * p.inverse;
    for (std::size_t r = 0; r < 9; ++r)
      for (std::size_t c = 0; c < 9; ++c)
        A[9 * r + c] = volume * p.C.entries[r] * p.C.entries[c] -
                       mixed * (F.entries[r] * p.C.entries[c] + p.C.entries[r] * F.entries[c]) +
                       (r == c ? p.shear : Real(0.0));
    const Real curl = p.pressure - p.shear * p.share;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int di = 1; di < 3; ++di)
          for (int dj = 1; dj < 3; ++dj) {
            const int k = (i + di) % 3, l = (j + dj) % 3;
            Real &entry = A[static_cast<std::size_t>(9 * (3 * i + j) + 3 * k + l)];
            entry = entry + (di == dj ? 1.0 : -1.0) * curl * F(3 - i - k, 3 - j - l);
          }
  }

 private:
  template <class Real>
  struct Parts {
    Matrix3<Real> C;
    Real inverse, pressure, shear, share;
    Parts(const GalleryNeoHookean &material, const Matrix3<Real> &F) : C(cofactor(F)) {
      const Real J = determinant(F), root = 1.0 / cbrt(J);
      inverse = 1.0 / J;
      pressure = 0.5 * material.kappa_ * (J - inverse);
      shear = material.mu_ * root * root;
      share = (1. / 3) * squared_norm(F) * inverse;
    }
  };
  double mu_, kappa_;
};

TEST(AccuracyCookTest, MaterialHasItsDerivatives) {
  const GalleryNeoHookean material(1.3, 0.3);
  const Matrix3<double> F{{1.1, 0.2, 0.05, -0.1, 0.9, 0.1, 0.02, 0.03, 1.2}};
  Tangent<double> A;
  const auto energy = [&](const Matrix3<double> &at) {
    return material.energy_density(Deformation(less_identity(at)));
  };
  const auto stress = [&](const Matrix3<double> &at) {
    return material.stress(Deformation(less_identity(at)));
  };
  material.tangent(Deformation(less_identity(F)), A);
  const double h = 1e-5;
  for (std::size_t q = 0; q < 9; ++q) {
    Matrix3<double> above = F, below = F;
    above.entries[q] += h;
    below.entries[q] -= h;
    EXPECT_NEAR((energy(above) - energy(below)) / (2 * h), stress(F).entries[q], 1e-8);
    for (std::size_t p = 0; p < 9; ++p)
      EXPECT_NEAR((stress(above).entries[p] - stress(below).entries[p]) / (2 * h), A[9 * p + q],
                  1e-7);
  }
}

/// Corners (0,0) (48,44) (48,60) (0,44), millimetres.
CellList cook_mesh(PetscInt resolution, int order) {
  CellList mesh = generate_mesh("square", resolution, 0);
  if (order == 2) promote_to_quadratic(mesh);
  for (std::size_t v = 0; 3 * v < mesh.coordinates.size(); ++v) {
    const double x = mesh.coordinates[3 * v], y = mesh.coordinates[3 * v + 1];
    mesh.coordinates[3 * v] = 48 * x;
    mesh.coordinates[3 * v + 1] = 44 * x + y * (44 - 28 * x);
  }
  return mesh;
}

std::optional<double> left_end(const double *p, int) {
  if (p[0] > 1e-9) return {};
  return 0;
}

/// Vertical displacement of the middle of the right side, (48, 52), in mm: 1 N on a thickness of
/// 1 mm.
double cook_tip(PetscInt resolution, int order, std::unique_ptr<MaterialModel> material,
                ElementPressure pressure = ElementPressure::pointwise) {
  Problem problem;
  std::vector<double> u;
  EXPECT_EQ(problem.set_up(cook_mesh(resolution, order), std::move(material), left_end, pressure),
            PETSC_SUCCESS);
  problem.add_edge_force(48, {0, 1});
  EXPECT_EQ(problem.solve(1e-14), PETSC_SUCCESS);
  EXPECT_EQ(problem.displacements(&u), PETSC_SUCCESS);
  double tip = 0;
  for (std::size_t v = 0; 3 * v < u.size(); ++v)
    if (std::hypot(problem.mesh.coordinates[3 * v] - 48, problem.mesh.coordinates[3 * v + 1] - 52) <
        1e-9)
      tip = u[3 * v + 1];
  return tip;
}

constexpr double shear_modulus = 0.4225;  // MPa

/// Of the gallery's material.
double cook_tip(PetscInt resolution, int order, double poisson) {
  return cook_tip(resolution, order,
                  make_material_model(GalleryNeoHookean(shear_modulus, poisson)));
}

TEST(AccuracyCookTest, TipOfTheMembrane) {
  const double reference = cook_tip(64, 2, 0.3);
  PetscPrintf(PETSC_COMM_WORLD, "Cook, nu .3: quadratic 64 x 64 %.4f mm\n", reference);
  // The code gallery has 14.74 mm on its finest mesh.
  EXPECT_NEAR(reference, 14.74, 0.006);
  double previous[2] = {0, 0};
  for (const PetscInt resolution : {8, 16, 32})
    for (const int order : {1, 2}) {
      const double tip = cook_tip(resolution, order, 0.3), error = std::abs(tip - reference);
      PetscPrintf(PETSC_COMM_WORLD, "  order %d, %2d x %2d: %.4f mm, error %.1e\n", order,
                  static_cast<int>(resolution), static_cast<int>(resolution), tip, error);
      double &before = previous[order - 1];
      if (before > 0) {
        EXPECT_LT(error, 0.6 * before);
      }
      before = error;
    }
  EXPECT_LT(previous[0], 0.05 * reference);
  EXPECT_LT(previous[1], 0.003 * reference);
}

/// A linear triangle locks at nu = .4999, a quadratic one hardly.
TEST(AccuracyCookTest, NearlyIncompressible) {
  const double reference = cook_tip(64, 2, 0.4999), linear = cook_tip(32, 1, 0.4999),
               quadratic = cook_tip(16, 2, 0.4999);
  PetscPrintf(PETSC_COMM_WORLD,
              "Cook, nu .4999: %.4f mm; linear 32 x 32 %.4f, quadratic 16 x 16 %.4f\n", reference,
              linear, quadratic);
  EXPECT_GT(std::abs(linear - reference), 5 * std::abs(quadratic - reference));
  EXPECT_LT(std::abs(quadratic - reference), 0.02 * reference);
}

/// With a pressure of their own quadratic triangles have less error on each mesh, at nu .4999 as at
/// .49999.
TEST(AccuracyCookTest, PressureOfTheElements) {
  for (const double poisson : {0.4999, 0.49999}) {
    const auto tip = [&](PetscInt resolution, ElementPressure pressure) {
      const ElasticConstants constants{2 * (1 + poisson) * shear_modulus, poisson};
      const StableNeoHookean material(constants, StableNeoHookean::Lame::physical);
      return cook_tip(resolution, 2, make_material_model(material), pressure);
    };
    const double reference = tip(64, ElementPressure::constant);
    PetscPrintf(PETSC_COMM_WORLD, "Cook, nu %g: P2-P0 64 x 64 %.4f mm\n", poisson, reference);
    double before = 0;
    for (const PetscInt resolution : {4, 8, 16}) {
      const double pointwise = std::abs(tip(resolution, ElementPressure::pointwise) - reference),
                   mean = std::abs(tip(resolution, ElementPressure::constant) - reference);
      PetscPrintf(PETSC_COMM_WORLD, "  %2d x %2d: error of tri6 %.1e, of P2-P0 %.1e\n",
                  static_cast<int>(resolution), static_cast<int>(resolution), pointwise, mean);
      EXPECT_LT(mean, 0.8 * pointwise);
      if (before > 0) {
        EXPECT_LT(mean, 0.6 * before);
      }
      before = mean;
    }
  }
}

/// What dead loads do while they grow from nothing ends up as elastic energy: the integral of f.du.
TEST(AccuracyCookTest, EnergyIsTheWorkOfTheLoads) {
  Problem problem;
  std::vector<double> u;
  ASSERT_EQ(problem.set_up(cook_mesh(8, 2), make_material_model(GalleryNeoHookean(0.4225, 0.3)),
                           left_end),
            PETSC_SUCCESS);
  constexpr int steps = 8;  // even
  // With W(t) = f.u(t) at full f: the work is t W - integral of W dt, by Simpson's rule.
  problem.add_edge_force(48, {0, 1});
  double values[steps + 1] = {0};
  for (int k = 1; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    problem.scale_forces(t);
    ASSERT_EQ(problem.solve(1e-16), PETSC_SUCCESS);
    problem.scale_forces(1 / t);
    ASSERT_EQ(problem.displacements(&u), PETSC_SUCCESS);
    values[k] = problem.work(u);
  }
  double integral = values[0] + values[steps];
  for (int k = 1; k < steps; ++k) integral += (k % 2 ? 4 : 2) * values[k];
  integral /= 3 * steps;
  const double energy = problem.elastic_energy(u), work = values[steps] - integral;
  PetscPrintf(PETSC_COMM_WORLD, "energy %.8f, work of the loads %.8f N mm\n", energy, work);
  EXPECT_NEAR(work / energy, 1, 1e-4);
}

/// Torsion of an incompressible neo-Hookean cylinder [Rivlin 1948, "Large elastic deformations of
/// isotropic materials, IV"]: (R, Theta, Z) -> (R, Theta + tau Z, Z) with traction-free sides takes
/// the torque pi mu tau a^4 / 2 and the normal force -pi mu tau^2 a^4 / 4 on its ends.
TEST(AccuracyTorsionTest, RivlinsCylinder) {
  constexpr double radius = 0.5, length = 2, tau = 0.6, pi = std::numbers::pi;
  CellList mesh = generate_mesh("cylinder", 3, 0);
  promote_to_quadratic(mesh);
  // Midpoints of edges on the side belong on the circle.
  for (std::size_t v = 0; 3 * v < mesh.coordinates.size(); ++v) {
    double *p = &mesh.coordinates[3 * v];
    const double r = std::hypot(p[0], p[1]);
    const double facet = radius * std::cos(pi / 18);  // 18 corners on the outer ring
    if (r < facet - 1e-9) continue;
    p[0] *= radius / r;
    p[1] *= radius / r;
  }
  ASSERT_EQ(
      first_bent_cell(reference_element(3, mesh.nodes_per_cell()), mesh.coordinates, mesh.cells),
      -1);
  const double poisson = 0.4999, mu = 1, young = 2 * mu * (1 + poisson);
  const StableNeoHookean material({young, poisson}, StableNeoHookean::Lame::physical);
  const VectorField twisted = [&](const double *p) -> std::array<double, 3> {
    const double c = std::cos(tau * p[2]), s = std::sin(tau * p[2]);
    return {c * p[0] - s * p[1] - p[0], s * p[0] + c * p[1] - p[1], 0};
  };
  const TensorField gradient = [&](const double *p) {
    const double c = std::cos(tau * p[2]), s = std::sin(tau * p[2]);
    return Matrix3<double>{
        {c, -s, tau * (-s * p[0] - c * p[1]), s, c, tau * (c * p[0] - s * p[1]), 0, 0, 1}};
  };
  Problem problem;
  std::vector<double> u;
  ASSERT_EQ(problem.set_up(mesh, make_material_model(material),
                           [&](const double *p, int i) -> std::optional<double> {
                             if (p[2] > 1e-9 && p[2] < length - 1e-9) return {};
                             return twisted(p)[static_cast<std::size_t>(i)];
                           }),
            PETSC_SUCCESS);
  ASSERT_EQ(problem.solve(1e-13), PETSC_SUCCESS);
  ASSERT_EQ(problem.displacements(&u), PETSC_SUCCESS);
  const Problem::Errors errors = problem.errors(u, twisted, gradient);
  const std::vector<double> forces = problem.forces(u);
  double torque = 0, normal = 0;
  for (std::size_t v = 0; 3 * v < u.size(); ++v) {
    const double *p = &problem.mesh.coordinates[3 * v];
    if (p[2] < length - 1e-9) continue;
    torque += (p[0] + u[3 * v]) * forces[3 * v + 1] - (p[1] + u[3 * v + 1]) * forces[3 * v];
    normal += forces[3 * v + 2];
  }
  const double exact_torque = pi * mu * tau * std::pow(radius, 4) / 2;
  const double exact_normal = -pi * mu * tau * tau * std::pow(radius, 4) / 4;
  PetscPrintf(
      PETSC_COMM_WORLD,
      "torsion: torque %.5f (exact %.5f), normal force %.5f (%.5f), error L2 %.1e H1 %.1e\n",
      torque, exact_torque, normal, exact_normal, errors.L2, errors.H1);
  EXPECT_NEAR(torque / exact_torque, 1, 0.01);
  EXPECT_NEAR(normal / exact_normal, 1, 0.05);
  EXPECT_LT(errors.L2, 2e-3);
}

}  // namespace
}  // namespace trefoil::accuracy
