#include "material/material_runs.hpp"

#include <algorithm>
#include <array>

namespace trefoil {
namespace {

/// The material of a pack whose lanes have several.
struct MixedMaterial {
  struct Part {
    const MaterialModel *material = nullptr;
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
  static void energy_densities(const void *mixed, const double *H, double *psi) {
    collect<1>(mixed, psi, [&](const Part &part, double *values) {
      part.material->energy_densities(H, values);
    });
  }
  static void energy_changes(const void *mixed, const double *H, const double *D, const double *S,
                             std::span<const PlanePoint> points, const double *weight,
                             double *sums) {
    for (const Part &part : static_cast<const MixedMaterial *>(mixed)->parts) {
      std::vector<double> values(lanes * points.size(), 0);
      part.material->energy_changes(H, D, S, points, weight, values.data());
      for (std::size_t k = 0; k < values.size(); ++k) {
        if (part.owns[k % lanes]) sums[k] += values[k];
      }
    }
  }
  static void stresses(const void *mixed, const double *H, double *P) {
    collect<9>(mixed, P,
               [&](const Part &part, double *values) { part.material->stresses(H, values); });
  }
  static void tangents(const void *mixed, const double *H, double *A) {
    collect<81>(mixed, A,
                [&](const Part &part, double *values) { part.material->tangents(H, values); });
  }
  static void mean_laws(const void *mixed, const double *J_minus_1, double *law) {
    collect<3>(mixed, law, [&](const Part &part, double *values) {
      part.material->mean_laws(J_minus_1, values);
    });
  }
};

std::shared_ptr<const MaterialModel> make_mixed_model(std::vector<MixedMaterial::Part> parts) {
  PackedFunctions functions{MixedMaterial::energy_densities, MixedMaterial::energy_changes,
                            MixedMaterial::stresses, MixedMaterial::tangents};
  std::shared_ptr<const MaterialModel> pointwise;
  if (std::any_of(parts.begin(), parts.end(),
                  [](const auto &part) { return part.material->splits_volume(); })) {
    functions.mean_law = MixedMaterial::mean_laws;
    std::vector<MixedMaterial::Part> pointwise_parts = parts;
    for (auto &part : pointwise_parts) part.material = &part.material->pointwise();
    pointwise = make_mixed_model(std::move(pointwise_parts));
  }
  return std::make_shared<MaterialModel>(
      functions, std::make_shared<MixedMaterial>(MixedMaterial{std::move(parts)}), 0, pointwise);
}

}  // namespace

MaterialRuns::MaterialRuns(std::unique_ptr<MaterialModel> material, PetscInt cells)
    : cells_(cells) {
  materials_.push_back(std::move(material));
  find_stiffnesses();
  runs_.push_back({0, (cells + lanes - 1) / lanes, materials_[0].get()});
}

MaterialRuns::MaterialRuns(std::vector<std::unique_ptr<MaterialModel>> materials,
                           std::vector<int> material_of_cell)
    : materials_(std::move(materials)),
      cells_(static_cast<PetscInt>(material_of_cell.size())),
      material_of_cell_(std::move(material_of_cell)) {
  find_stiffnesses();
  make_runs();
}

MaterialRuns MaterialRuns::by_stiffness(
    const std::function<std::unique_ptr<MaterialModel>(double stiffness)> &make) const {
  std::vector<std::unique_ptr<MaterialModel>> others;
  for (const double stiffness : stiffness_) others.push_back(make(stiffness));
  if (material_of_cell_.empty()) return {std::move(others.front()), cells_};
  return {std::move(others), material_of_cell_};
}

void MaterialRuns::find_stiffnesses() {
  const Matrix3<double> at_rest;
  for (const auto &material : materials_) {
    Tangent<double> tangent;
    material->tangent(at_rest, tangent);
    double trace = 0;
    for (std::size_t p = 0; p < 9; ++p) trace += tangent[10 * p];
    stiffness_.push_back(trace / 9);
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
        part = parts.insert(part, {material, {}});
      }
      part->owns[static_cast<std::size_t>(lane)] = true;
    }
    if (parts.size() > 1) {
      mixed_.push_back(make_mixed_model(std::move(parts)));
      runs_.push_back({pack, 1, mixed_.back().get()});
    } else if (!runs_.empty() && runs_.back().material == parts[0].material) {
      ++runs_.back().count;
    } else {
      runs_.push_back({pack, 1, parts[0].material});
    }
  }
}

double MaterialRuns::bytes() const {
  return static_cast<double>(material_of_cell_.capacity() * sizeof(int) +
                             runs_.capacity() * sizeof(Run) +
                             mixed_.size() * sizeof(MixedMaterial));
}

}  // namespace trefoil
