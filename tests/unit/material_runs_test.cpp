// A body of several materials: what each element has is what it has in a body of its material
// alone, also in packs that several share.

#include "material/material_runs.hpp"

#include <gtest/gtest.h>

#include "element/isoparametric_element.hpp"
#include "filter/reduced_filter.hpp"
#include "matrix3_support.hpp"
#include "mesh/generate.hpp"
#include "mesh/quadratic.hpp"
#include "support/petsc_compatibility.hpp"
#include "term/elastic_term.hpp"
#include "trefoil/material_registry.hpp"

namespace trefoil::test {
namespace {

const std::vector<std::string> names{"stable_neo_hookean", "arap", "neo_hookean"};

std::unique_ptr<MaterialModel> material(std::size_t which) {
  return make_material(names[which], {{which == 1 ? 1e6 : 2.0, 0.3}});
}

class MaterialRunsTest : public testing::Test {
 protected:
  MaterialRunsTest() {
    const CellList whole = generate_mesh("box", 3, 0);
    mesh_.cells = whole.cells;
    mesh_.cells.resize(4 * 157);  // 19 packs and five cells
    mesh_.coordinates = whole.coordinates;
    Random random(8);
    for (std::size_t k = 0; k < mesh_.coordinates.size(); ++k) {
      u_.push_back(0.02 * random.uniform());
      direction_.push_back(0.01 * random.uniform());
    }
    for (PetscInt c = 0; c < mesh_.local_cells(); ++c) {
      material_of_cell_.push_back(c < 80 ? c % 3 : c < 100 ? 2 : c < 128 ? 1 : 0);
    }
  }

  [[nodiscard]] ElasticTerm mixed() const {
    std::vector<std::unique_ptr<MaterialModel>> materials;
    for (std::size_t m = 0; m < names.size(); ++m) materials.push_back(material(m));
    return {mesh_, MaterialRuns(std::move(materials), material_of_cell_), FilterSpace::element};
  }

  [[nodiscard]] std::vector<double> hessians(const ElasticTerm &term, PetscInt first,
                                             PetscInt count) const {
    std::vector<double> K(static_cast<std::size_t>(count * reduced_entries * lanes));
    term.batch()->hessians(first, count, u_.data(), K.data());
    return K;
  }

  Mesh mesh_;
  std::vector<double> u_, direction_;
  std::vector<int> material_of_cell_;
};

TEST_F(MaterialRunsTest, RunsAreAsLongAsTheyCanBe) {
  std::vector<std::unique_ptr<MaterialModel>> materials;
  for (std::size_t m = 0; m < names.size(); ++m) materials.push_back(material(m));
  const MaterialRuns runs(std::move(materials), material_of_cell_);
  std::vector<std::array<PetscInt, 3>> found;
  for (const auto &run : runs.runs()) {
    const bool is_mixed = run.material != &runs.of_cell(lanes * run.first);
    found.push_back({run.first, run.count, is_mixed});
  }
  std::vector<std::array<PetscInt, 3>> expected;
  for (PetscInt pack = 0; pack < 10; ++pack) expected.push_back({pack, 1, 1});
  // Cells 80 to 95, the pack of 96 to 103, up to 127, and the rest, its filled-up pack included.
  for (const auto &run :
       std::vector<std::array<PetscInt, 3>>{{10, 2, 0}, {12, 1, 1}, {13, 3, 0}, {16, 4, 0}})
    expected.push_back(run);
  EXPECT_EQ(found, expected);
}

TEST_F(MaterialRunsTest, HessiansAreThoseOfEachMaterialAlone) {
  const ElasticTerm term = mixed();
  for (const auto &[first, count] : {std::pair<PetscInt, PetscInt>{0, 20}, {7, 9}, {11, 1}}) {
    const std::vector<double> K = hessians(term, first, count);
    for (std::size_t m = 0; m < names.size(); ++m) {
      const std::vector<double> alone =
          hessians(ElasticTerm(mesh_, material(m), FilterSpace::element), first, count);
      for (std::size_t k = 0; k < K.size(); ++k) {
        const std::size_t pack = k / (reduced_entries * lanes), lane = k % lanes;
        const std::size_t cell = std::min((static_cast<std::size_t>(first) + pack) * lanes + lane,
                                          material_of_cell_.size() - 1);
        if (material_of_cell_[cell] == static_cast<int>(m)) {
          ASSERT_EQ(K[k], alone[k]) << cell;
        }
      }
    }
  }
}

TEST_F(MaterialRunsTest, EnergyIsTheSumOverTheCells) {
  const ElasticTerm term = mixed();
  EnergySums sums, expected;
  EXPECT_EQ(term.add_energy(u_.data(), &sums), PETSC_SUCCESS);
  std::vector<double> determinant(material_of_cell_.size()), density(determinant.size());
  term.describe_cells(u_.data(), determinant.data(), density.data());
  constexpr double volume = 1. / 162;
  double rest_energy = 0;
  for (std::size_t c = 0; c < density.size(); ++c) {
    expected.energy += volume * density[c];
    expected.scale += volume * std::abs(density[c]);
    const auto model = material(static_cast<std::size_t>(material_of_cell_[c]));
    rest_energy += volume * model->rest_energy_density();
  }
  EXPECT_NEAR(sums.energy / expected.energy, 1, 1e-12);
  EXPECT_NEAR(sums.scale / expected.scale, 1, 1e-12);
  EXPECT_NEAR(term.rest_energy() / rest_energy, 1, 1e-12);
  EXPECT_GT(rest_energy, 0) << "stable Neo-Hookean's";
  const std::vector<double> rest(u_.size(), 0);
  EnergySums still;
  EXPECT_EQ(term.add_energy(rest.data(), &still), PETSC_SUCCESS);
  EXPECT_EQ(still.scale, 0);
  EXPECT_EQ(still.energy, 0);
}

TEST_F(MaterialRunsTest, GradientAndChangesAreThoseOfTheEnergy) {
  const ElasticTerm term = mixed();
  const auto energy_at = [&](double s) {
    std::vector<double> moved = u_;
    for (std::size_t k = 0; k < moved.size(); ++k) moved[k] += s * direction_[k];
    EnergySums sums;
    EXPECT_EQ(term.add_energy(moved.data(), &sums), PETSC_SUCCESS);
    return sums.energy;
  };
  std::vector<double> gradient(u_.size(), 0);
  EXPECT_EQ(term.add_gradient(u_.data(), gradient.data()), PETSC_SUCCESS);
  double slope = 0, size = 0;
  for (std::size_t k = 0; k < gradient.size(); ++k) {
    slope += gradient[k] * direction_[k];
    size += std::abs(gradient[k] * direction_[k]);
  }
  EXPECT_NEAR(derivative(1e-2, energy_at), slope, 1e-7 * size);

  const double coefficients[] = {-0.5, 0.25, 1};
  const double *directions[] = {direction_.data()};
  double changes[3] = {0, 0, 0};
  EXPECT_EQ(term.add_energy_changes(u_.data(), u_.size(), 1, directions, 3, coefficients, changes),
            PETSC_SUCCESS);
  for (int point = 0; point < 3; ++point) {
    const double change = energy_at(coefficients[point]) - energy_at(0);
    EXPECT_NEAR(changes[point] / change, 1, 1e-9) << point;
  }
}

/// Spreading energies keep the cells' stiffnesses apart.
TEST_F(MaterialRunsTest, SpreadingKeepsTheStiffness) {
  std::vector<std::unique_ptr<MaterialModel>> materials;
  for (std::size_t m = 0; m < names.size(); ++m) materials.push_back(material(m));
  const MaterialRuns runs(std::move(materials), material_of_cell_);
  const MaterialRuns spreading = runs.by_stiffness(
      [](double stiffness) { return make_material_model(HarmonicSpreading(stiffness)); });
  for (const PetscInt cell : {0, 1, 2, 79, 99, 127, 156})
    EXPECT_NEAR(spreading.stiffness_of(cell) / runs.stiffness_of(cell), 1, 1e-12) << cell;
  EXPECT_GT(runs.stiffness_of(1), 1e5 * runs.stiffness_of(0));
}

/// Bodies of triangles and quadratic elements, the latter bent, whose packs several materials
/// share.
class ElementRunsTest : public testing::TestWithParam<std::pair<const char *, int>> {
 protected:
  ElementRunsTest() {
    CellList whole = generate_mesh(GetParam().first, 3, 0);
    const auto corners = whole.coordinates.size();
    if (GetParam().second == 2) promote_to_quadratic(whole);
    mesh_.shape = whole.shape;
    mesh_.cells = whole.cells;
    mesh_.coordinates = whole.coordinates;
    Random random(8);
    for (std::size_t k = 0; k < whole.coordinates.size(); ++k) {
      const bool in_plane = static_cast<int>(k % 3) < whole.dimension();
      if (k >= corners && in_plane) mesh_.coordinates[k] += 0.01 * random.uniform();
      u_.push_back(in_plane ? 0.01 * random.uniform() : 0);
    }
    for (PetscInt c = 0; c < mesh_.local_cells(); ++c) material_of_cell_.push_back(c % 3);
  }

  [[nodiscard]] ElasticTerm term(FilterSpace space) const {
    std::vector<std::unique_ptr<MaterialModel>> materials;
    for (std::size_t m = 0; m < names.size(); ++m) materials.push_back(material(m));
    return {mesh_, MaterialRuns(std::move(materials), material_of_cell_), space};
  }
  [[nodiscard]] const PetscInt *nodes(std::size_t cell) const {
    return &mesh_.cells[static_cast<std::size_t>(mesh_.nodes_per_cell()) * cell];
  }
  /// The numbers of a cell's nodes, three each.
  [[nodiscard]] std::vector<double> of_cell(const std::vector<double> &all,
                                            std::size_t cell) const {
    std::vector<double> own;
    for (int a = 0; a < mesh_.nodes_per_cell(); ++a)
      for (int i = 0; i < 3; ++i)
        own.push_back(all[static_cast<std::size_t>(3 * nodes(cell)[a] + i)]);
    return own;
  }

  Mesh mesh_;
  std::vector<double> u_;
  std::vector<int> material_of_cell_;
};

TEST_P(ElementRunsTest, SumsAndCellsAreThoseOfTheQuadraturePoints) {
  const ElasticTerm body = term(FilterSpace::element);
  const std::size_t cells = material_of_cell_.size();
  EnergySums sums, expected;
  std::vector<double> determinants(cells), densities(cells);
  EXPECT_EQ(body.add_energy(u_.data(), &sums), PETSC_SUCCESS);
  body.describe_cells(u_.data(), determinants.data(), densities.data());
  double spread = 0, expected_stiffness = 0, expected_rest = 0;
  for (std::size_t c = 0; c < cells; ++c) {
    const auto model = material(static_cast<std::size_t>(material_of_cell_[c]));
    const IsoparametricElement element(reference_element(mesh_.dimension(), mesh_.nodes_per_cell()),
                                       of_cell(mesh_.coordinates, c).data());
    Tangent<double> A;
    model->tangent(Matrix{}, A);
    double least = 1e300, most = -1e300, energy = 0, volume = 0, stiffness = 0;
    for (std::size_t p = 0; p < 9; ++p) stiffness += A[10 * p] / 9;
    for (int q = 0; q < element.reference().points; ++q) {
      const Matrix H = element.displacement_gradient(q, of_cell(u_, c).data());
      const double psi = model->energy_density(H), weight = element.weight(q);
      const double J = determinant(along(H, 1, diagonal(1, 1, 1)));
      least = std::min(least, J);
      most = std::max(most, J);
      energy += weight * psi;
      volume += weight;
      expected.scale += weight * std::abs(psi);
      for (int a = 0; a < element.reference().nodes; ++a)
        for (int i = 0; i < 3; ++i)
          expected_stiffness += stiffness * weight * std::pow(element.gradient(q, a)[i], 2);
    }
    expected.energy += energy;
    expected_rest += volume * model->rest_energy_density();
    spread = std::max(spread, most - least);
    EXPECT_NEAR(determinants[c], least, 1e-13) << c;
    EXPECT_NEAR(densities[c] / (energy / volume), 1, 1e-10) << c;
  }
  EXPECT_NEAR(sums.energy / expected.energy, 1, 1e-12);
  EXPECT_NEAR(sums.scale / expected.scale, 1, 1e-12);
  EXPECT_EQ(sums.strain_energy, sums.energy);
  EXPECT_NEAR(body.stiffness() / expected_stiffness, 1, 1e-12);
  EXPECT_NEAR(body.rest_energy() / expected_rest, 1, 1e-12);
  if (GetParam().second == 2) {
    EXPECT_GT(spread, 0.01) << "the points of a cell are all alike";
  }
}

TEST_P(ElementRunsTest, WhatIsNotFiniteAtAPointIsSoInItsElement) {
  const ElasticTerm body = term(FilterSpace::deformation);
  const PackedElements &packed = *body.batch();
  const PetscInt packs = packed.elements().packs(), node = nodes(material_of_cell_.size() - 1)[0];
  std::vector<double> K(static_cast<std::size_t>(packs * packed.elements().entries() * lanes)),
      N(K.size());
  std::vector<int> before(static_cast<std::size_t>(packs * lanes)), after(before.size());
  const auto split = [&](std::vector<int> &negative) {
    packed.hessians(0, packs, u_.data(), K.data());
    return packed.split(0, packs, u_.data(), K.data(), N.data(), negative.data());
  };
  EXPECT_EQ(split(before).status, SplitStatus::ok);
  u_[static_cast<std::size_t>(3 * node)] = std::numeric_limits<double>::quiet_NaN();
  const SplitResult result = split(after);
  EXPECT_EQ(result.status, SplitStatus::not_finite);
  int first = -1, indefinite = 0;
  for (std::size_t c = 0; c < material_of_cell_.size(); ++c) {
    const bool touched = std::count(nodes(c), nodes(c) + mesh_.nodes_per_cell(), node) > 0;
    EXPECT_EQ(after[c], touched ? -1 : before[c]) << c;
    if (touched && first < 0) first = static_cast<int>(c);
  }
  for (const int count : after) indefinite += count > 0;
  EXPECT_EQ(result.first_bad, first / lanes * lanes) << "its pack's first";
  EXPECT_EQ(result.indefinite, indefinite);
}

INSTANTIATE_TEST_SUITE_P(Elements, ElementRunsTest,
                         testing::Values(std::pair{"square", 1}, std::pair{"square", 2},
                                         std::pair{"box", 2}),
                         [](const auto &each) {
                           return std::string(each.param.first) + "_order_" +
                                  std::to_string(each.param.second);
                         });

}  // namespace
}  // namespace trefoil::test
