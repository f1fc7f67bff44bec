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

}  // namespace

std::vector<MaterialOptions> named_materials(const SceneOptions &options) {
  std::vector<MaterialOptions> named{options.material};
  for (const RegionOptions &region : options.regions) named.push_back(region.material);
  return named;
}

bool is_nearly_incompressible(const SceneOptions &options) {
  const std::vector<MaterialOptions> named = named_materials(options);
  return std::any_of(named.begin(), named.end(), [](const MaterialOptions &material) {
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
  for (const MaterialOptions &material : named_materials(options)) {
    const double poisson = poisson_at_rest(material);
    largest = std::max(largest, 2 * poisson / (1 - 2 * poisson));
  }
  return largest;
}

}  // namespace trefoil
