#include "assembly/block_sums.hpp"

#include <algorithm>
#include <tuple>

#include "simd/instruction_set.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// A block of an element and the vertices that it belongs to.
struct Source {
  PetscInt row, column;
  std::uint16_t block;
  bool operator<(const Source &other) const {
    return std::tie(row, column, block) < std::tie(other.row, other.column, other.block);
  }
  [[nodiscard]] bool same_pair(const Source &other) const {
    return row == other.row && column == other.column;
  }
};

/// All blocks of a tile's elements, from pack `first` on, by pair of vertices.
void find_sources(const ElementPacks &elements, PetscInt first, std::vector<Source> *sources) {
  const int nodes = elements.reference->nodes;
  sources->clear();
  const PetscInt packs = std::min(tile_packs(nodes), elements.packs() - first);
  for (PetscInt e = 0; e < lanes * packs && lanes * first + e < elements.elements; ++e) {
    const PetscInt *vertex =
        &elements.nodes[static_cast<std::size_t>(nodes * lanes * (first + e / lanes) + e % lanes)];
    PetscInt block = upper_blocks(nodes) * lanes * (e / lanes) + e % lanes;
    for (int a = 0; a < nodes; ++a) {
      for (int b = a; b < nodes; ++b, block += lanes) {
        sources->push_back(
            {vertex[lanes * a], vertex[lanes * b], static_cast<std::uint16_t>(block)});
      }
    }
  }
  std::sort(sources->begin(), sources->end());
}

}  // namespace

PetscErrorCode make_block_sums(const ElementPacks &elements, const PlaceOfBlock &place,
                               BlockSums *sums) {
  struct Sum {
    BlockSums::Pair pair;
    std::vector<Source>::const_iterator first;
  };
  std::vector<Source> sources;
  std::vector<Sum> tile;
  PetscFunctionBeginUser;
  for (PetscInt first = 0; first < elements.packs();
       first += tile_packs(elements.reference->nodes)) {
    find_sources(elements, first, &sources);
    tile.clear();
    for (auto begin = sources.cbegin(), end = begin; begin != sources.cend(); begin = end) {
      end = std::find_if_not(begin, sources.cend(),
                             [&](const Source &source) { return source.same_pair(*begin); });
      BlockSums::Pair pair{{}, {}, static_cast<std::int32_t>(end - begin)};
      PetscCall(place(begin->row, begin->column, &pair.upper));
      if (!pair.upper.exists()) continue;
      if (begin->row != begin->column) PetscCall(place(begin->column, begin->row, &pair.lower));
      tile.push_back({pair, begin});
    }
    std::stable_sort(tile.begin(), tile.end(),
                     [](const Sum &a, const Sum &b) { return a.pair.count < b.pair.count; });
    sums->first_pair.push_back(sums->pairs.size());
    sums->first_block.push_back(sums->blocks.size());
    for (const Sum &sum : tile) {
      sums->pairs.push_back(sum.pair);
      for (auto source = sum.first; source != sum.first + sum.pair.count; ++source) {
        sums->blocks.push_back(source->block);
      }
    }
  }
  sums->first_pair.push_back(sums->pairs.size());
  sums->first_block.push_back(sums->blocks.size());
  sums->pairs.shrink_to_fit();
  sums->blocks.shrink_to_fit();
  PetscFunctionReturn(PETSC_SUCCESS);
}

double BlockSums::bytes() const {
  return static_cast<double>(
      pairs.capacity() * sizeof(Pair) + blocks.capacity() * sizeof(std::uint16_t) +
      (first_pair.capacity() + first_block.capacity()) * sizeof(std::size_t) +
      numbers.capacity() * sizeof(std::int32_t));
}

AddBlocks add_blocks_kernel(const ReferenceElement &reference, InstructionSet instructions) {
  return for_instruction_set(instructions, [&]<InstructionSet isa>() {
    return make_add_blocks<isa>(reference.dimension, reference.nodes);
  });
}

}  // namespace trefoil
