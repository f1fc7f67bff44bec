#include "element/tet4_packs.hpp"

#include <algorithm>
#include <array>

#include "element/tet4.hpp"
#include "mesh/mesh.hpp"
#include "simd/instruction_set.hpp"

namespace trefoil {

Tet4Packs pack_tetrahedra(const Mesh &mesh) {
  static constexpr double hadamard[3][4] = {
      {.5, .5, -.5, -.5}, {.5, -.5, .5, -.5}, {.5, -.5, -.5, .5}};
  Tet4Packs tets;
  tets.elements = mesh.local_cells();
  const auto packs = static_cast<std::size_t>(tets.packs());
  tets.gradients.resize(packs * 9 * lanes);
  tets.volumes.resize(packs * lanes);
  tets.vertices.resize(packs * 4 * lanes);
  for (std::size_t e = 0; e < packs * lanes; ++e) {
    const std::size_t pack = e / lanes, lane = e % lanes;
    const std::size_t cell = std::min(e, static_cast<std::size_t>(tets.elements) - 1);
    const PetscInt *vertex = &mesh.cells[4 * cell];
    double corner[4][3];
    std::array<std::size_t, 4> order{0, 1, 2, 3};
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t i = 0; i < 3; ++i) {
        corner[a][i] = mesh.coordinates[static_cast<std::size_t>(3 * vertex[a]) + i];
      }
    }
    const Tet4 tet = Tet4::at_rest(corner);
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return vertex[a] < vertex[b]; });
    for (std::size_t a = 0; a < 4; ++a) {
      tets.vertices[(4 * pack + a) * lanes + lane] = vertex[order[a]];
    }
    tets.volumes[pack * lanes + lane] = cell == e ? tet.volume : 0;
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        double sum = 0;
        for (std::size_t a = 0; a < 4; ++a) {
          sum += hadamard[k][a] * tet.gradients[order[a]][i];
        }
        tets.gradients[(9 * pack + 3 * k + i) * lanes + lane] = sum;
      }
    }
  }
  return tets;
}

Tet4Kernels tet4_kernels(InstructionSet instructions) {
  return for_instruction_set(instructions,
                             []<InstructionSet isa>() { return make_tet4_kernels<isa>(); });
}

}  // namespace trefoil
