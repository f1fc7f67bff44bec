#include "material/material_runs.hpp"

#include <algorithm>
#include <array>

namespace trefoil {
namespace {

/// The material of a pack whose lanes have several. Its energy density is counted from each lane's
/// own rest density.
struct MixedMaterial {
  struct Part {
    const MaterialModel *material = nullptr;
    double rest_density = 0;
    std::array<bool, lanes> owns{};  ///< which lanes are of this material
  };
  std::vector<Part> parts;

  /// Evaluates each part for all lanes and keeps its own: result[k * lanes + lane].
  template <std::size_t size, class Evaluate>
  static void collect(const void *mixed, double *result, Evaluate evaluate) {
    for (const Part &part : static_cast<const MixedMaterial *>(mixed)->parts) {
      alignas(64) double values[size * lanes];
      evaluate(part, values);
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        for (std::size_t k = 0; part.owns[lane] && k < size; ++k) {
          result[lanes * k + lane] = values[lanes * k + lane];
        }
      }
    }
  }
  static void energy_densities(const void *mixed, const double *F, double *psi) {
    collect<1>(mixed, psi, [F](const Part &part, double *values) {
      part.material->energy_densities(F, values);
      for (int lane = 0; lane < lanes; ++lane) values[lane] -= part.rest_density;
    });
  }
  static void stresses(const void *mixed, const double *F, double *P) {
    collect<9>(mixed, P,
               [F](const Part &part, double *values) { part.material->stresses(F, values); });
  }
  static void tangents(const void *mixed, const double *F, double *A) {
    collect<81>(mixed, A,
                [F](const Part &part, double *values) { part.material->tangents(F, values); });
  }
};

std::unique_ptr<MaterialModel> make_mixed_model(std::vector<MixedMaterial::Part> parts) {
  return std::make_unique<MaterialModel>(
      PackedFunctions{MixedMaterial::energy_densities, MixedMaterial::stresses,
                      MixedMaterial::tangents},
      std::make_shared<MixedMaterial>(MixedMaterial{std::move(parts)}));
}

}  // namespace

MaterialRuns::MaterialRuns(std::unique_ptr<MaterialModel> material, PetscInt cells)
    : cells_(cells) {
  materials_.push_back(std::move(material));
  describe_rest();
  runs_.push_back({0, (cells + lanes - 1) / lanes, materials_[0].get(), rest_densities_[0], false});
}

MaterialRuns::MaterialRuns(std::vector<std::unique_ptr<MaterialModel>> materials,
                           std::vector<int> material_of_cell)
    : materials_(std::move(materials)),
      cells_(static_cast<PetscInt>(material_of_cell.size())),
      material_of_cell_(std::move(material_of_cell)) {
  describe_rest();
  make_runs();
}

MaterialRuns MaterialRuns::by_stiffness(
    const std::function<std::unique_ptr<MaterialModel>(double stiffness)> &make) const {
  std::vector<std::unique_ptr<MaterialModel>> others;
  for (const double stiffness : stiffness_) others.push_back(make(stiffness));
  if (material_of_cell_.empty()) return {std::move(others.front()), cells_};
  return {std::move(others), material_of_cell_};
}

void MaterialRuns::describe_rest() {
  Matrix3<double> identity;
  for (int i = 0; i < 3; ++i) identity(i, i) = 1;
  for (const auto &material : materials_) {
    Tangent<double> tangent;
    material->tangent(identity, tangent);
    double trace = 0;
    for (std::size_t p = 0; p < 9; ++p) trace += tangent[10 * p];
    stiffness_.push_back(trace / 9);
    rest_densities_.push_back(material->energy_density(identity));
  }
}

void MaterialRuns::make_runs() {
  for (PetscInt begin = 0, pack = 0; begin < cells_; begin += lanes, ++pack) {
    std::vector<MixedMaterial::Part> parts;
    for (int lane = 0; lane < lanes; ++lane) {
      // The last cell fills up the last pack, as in the packs of elements.
      const PetscInt cell = std::min(begin + lane, cells_ - 1);
      const MaterialModel *material = &of_cell(cell);
      auto part = std::find_if(parts.begin(), parts.end(),
                               [&](const auto &each) { return each.material == material; });
      if (part == parts.end()) {
        part = parts.insert(part, {material, rest_density_of(cell), {}});
      }
      part->owns[static_cast<std::size_t>(lane)] = true;
    }
    if (parts.size() > 1) {
      mixed_.push_back(make_mixed_model(std::move(parts)));
      runs_.push_back({pack, 1, mixed_.back().get(), 0, true});
    } else if (!runs_.empty() && runs_.back().material == parts[0].material) {
      ++runs_.back().count;
    } else {
      runs_.push_back({pack, 1, parts[0].material, parts[0].rest_density, false});
    }
  }
}

double MaterialRuns::bytes() const {
  return static_cast<double>(material_of_cell_.capacity() * sizeof(int) +
                             runs_.capacity() * sizeof(Run) +
                             mixed_.size() * sizeof(MixedMaterial));
}

}  // namespace trefoil
