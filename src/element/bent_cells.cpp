#include "element/bent_cells.hpp"

#include "element/isoparametric_element.hpp"

namespace trefoil {

PetscInt first_bent_cell(const ReferenceElement &reference, const std::vector<double> &coordinates,
                         const std::vector<PetscInt> &cells) {
  const auto width = static_cast<std::size_t>(reference.nodes);
  std::vector<double> positions(3 * width);
  for (std::size_t c = 0; c < cells.size(); c += width) {
    for (std::size_t k = 0; k < 3 * width; ++k) {
      positions[k] = coordinates[3 * static_cast<std::size_t>(cells[c + k / 3]) + k % 3];
    }
    const IsoparametricElement element(reference, positions.data());
    // Written so that a NaN counts as bent.
    if (!(element.least_jacobian() > 0)) return static_cast<PetscInt>(c / width);
  }
  return -1;
}

}  // namespace trefoil
