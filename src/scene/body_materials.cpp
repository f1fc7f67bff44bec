#include "scene/body_materials.hpp"

#include <algorithm>
#include <memory>
#include <utility>

namespace trefoil {
namespace {

std::unique_ptr<MaterialModel> make_softer(MaterialOptions material, double most_volumetric) {
  ElasticConstants &constants = material.parameters.constants;
  const double most = most_volumetric * constants.mu();
  if (constants.lambda() > most) {
    constants = ElasticConstants::from_lame(constants.mu(), most);
  }
  if (auto &weight = material.parameters.volume) weight = std::min(*weight, most);
  return make_material(material);
}

/// The body's material, then those of its regions.
std::vector<MaterialOptions> named_materials(const SceneOptions &options) {
  std::vector<MaterialOptions> named{options.material};
  for (const RegionOptions &region : options.regions) named.push_back(region.material);
  return named;
}

}  // namespace

std::vector<MaterialOptions> materials_of_cells(const SceneOptions &options) {
  std::vector<MaterialOptions> materials = named_materials(options);
  if (options.is_all_regions) materials.erase(materials.begin());
  return materials;
}

bool is_nearly_incompressible(const SceneOptions &options) {
  const std::vector<MaterialOptions> materials = materials_of_cells(options);
  return std::any_of(materials.begin(), materials.end(), [](const MaterialOptions &material) {
    return is_nearly_incompressible(material);
  });
}

MaterialRuns body_materials(const SceneOptions &options, const Mesh &mesh,
                            const std::vector<int> &region_of_cell, double most_volumetric) {
  std::vector<std::unique_ptr<MaterialModel>> materials;
  for (const MaterialOptions &material : named_materials(options)) {
    materials.push_back(make_softer(material, most_volumetric));
  }
  if (options.regions.empty()) return {std::move(materials.front()), mesh.local_cells()};
  return {std::move(materials), region_of_cell};
}

double largest_volumetric(const SceneOptions &options) {
  double largest = 0;
  for (const MaterialOptions &material : materials_of_cells(options)) {
    const double poisson = poisson_at_rest(material);
    largest = std::max(largest, 2 * poisson / (1 - 2 * poisson));
  }
  return largest;
}

}  // namespace trefoil
