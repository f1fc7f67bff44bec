#include "element/block_sums.hpp"

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

/// All blocks of the elements from pack `first` on, by pair of vertices.
void find_sources(const Tet4Packs &tets, PetscInt first, std::vector<Source> *sources) {
  sources->clear();
  const PetscInt packs = std::min(BlockSums::stretch, tets.packs() - first);
  for (PetscInt e = 0; e < lanes * packs && lanes * first + e < tets.elements; ++e) {
    const PetscInt *vertex =
        &tets.vertices[static_cast<std::size_t>(4 * lanes * (first + e / lanes) + e % lanes)];
    PetscInt block = upper_blocks * lanes * (e / lanes) + e % lanes;
    for (int a = 0; a < 4; ++a) {
      for (int b = a; b < 4; ++b, block += lanes) {
        sources->push_back(
            {vertex[lanes * a], vertex[lanes * b], static_cast<std::uint16_t>(block)});
      }
    }
  }
  std::sort(sources->begin(), sources->end());
}

}  // namespace

PetscErrorCode make_block_sums(const Tet4Packs &tets, const PlaceOfBlock &place, BlockSums *sums) {
  struct Sum {
    BlockSums::Pair pair;
    std::vector<Source>::const_iterator first;
  };
  std::vector<Source> sources;
  std::vector<Sum> stretch;
  PetscFunctionBeginUser;
  for (PetscInt first = 0; first < tets.packs(); first += BlockSums::stretch) {
    find_sources(tets, first, &sources);
    stretch.clear();
    for (auto begin = sources.cbegin(), end = begin; begin != sources.cend(); begin = end) {
      end = std::find_if_not(begin, sources.cend(),
                             [&](const Source &source) { return source.same_pair(*begin); });
      BlockSums::Pair pair{{}, {}, static_cast<std::int32_t>(end - begin)};
      PetscCall(place(begin->row, begin->column, &pair.upper));
      if (!pair.upper.exists()) continue;
      if (begin->row != begin->column) PetscCall(place(begin->column, begin->row, &pair.lower));
      stretch.push_back({pair, begin});
    }
    std::stable_sort(stretch.begin(), stretch.end(),
                     [](const Sum &a, const Sum &b) { return a.pair.count < b.pair.count; });
    sums->first_pair.push_back(sums->pairs.size());
    sums->first_block.push_back(sums->blocks.size());
    for (const Sum &sum : stretch) {
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

AddBlocks add_blocks_kernel(InstructionSet instructions) {
  return for_instruction_set(instructions,
                             []<InstructionSet isa>() { return make_add_blocks<isa>(); });
}

}  // namespace trefoil
