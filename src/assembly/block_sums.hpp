#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "element/element_packs.hpp"

namespace trefoil {

/// Where a dim x dim block of a matrix lies, in one of up to three arrays: dim runs of dim numbers,
/// `stride` apart.
struct BlockPlace {
  std::int32_t code = -1;   ///< array in the two lowest bits, the rest is the first number's place
  std::int32_t stride = 3;  ///< 0: each number has a code of its own, from code >> 2 on
  [[nodiscard]] bool exists() const { return code >= 0; }
};

/// How the dim x dim blocks of elements add up to the blocks of a matrix.
///
/// The elements are worked on in tiles of packs. All blocks of a tile that belong to one pair of
/// vertices (v, w) are summed in registers, and their sum is added to the matrix: as it is at
/// (v, w), transposed at (w, v). Neighbours lie in the same tile, so that the matrix of linear
/// tetrahedra is touched a sixth as often as by one element after the other.
struct BlockSums {
  struct Pair {
    BlockPlace upper, lower;  ///< at (v, w) and at (w, v); the latter does not exist if v = w
    std::int32_t count;       ///< blocks to sum
  };
  /// By tile, and in it by count, so that the processor foresees where each sum ends.
  std::vector<Pair> pairs;
  /// The blocks to sum, for one pair after the other: lane + 8 (block + upper_blocks (pack of the
  /// tile)).
  std::vector<std::uint16_t> blocks;
  std::vector<std::size_t> first_pair, first_block;  ///< of each tile, and one more

  /// Codes of the numbers of blocks without a stride, row by row; -1: the number does not exist.
  std::vector<std::int32_t> numbers;

  [[nodiscard]] double bytes() const;
};

/// Blocks (a, b), a <= b, of an element.
constexpr int upper_blocks(int nodes) {
  return nodes * (nodes + 1) / 2;
}
/// Packs of a tile: their blocks, at most 260 kB, stay in the second-level cache.
constexpr PetscInt tile_packs(int nodes) {
  return nodes > 6 ? 8 : 32;
}

/// Finds all sums. Blocks whose place does not exist are left out.
/// @param place where block (row, column) of two local vertices lies
using PlaceOfBlock =
    std::function<PetscErrorCode(PetscInt row, PetscInt column, BlockPlace *place)>;
PetscErrorCode make_block_sums(const ElementPacks &elements, const PlaceOfBlock &place,
                               BlockSums *sums);

/// Expands reduced matrices of packs [first, first + count) to the elements' blocks and adds them.
/// @param expand of the elements' kernels
/// @param first a multiple of tile_packs()
/// @param K as ElementKernels::hessians writes it
/// @param chosen elements to add, by lane of the packs: those where it is positive; null: all
/// @param arrays what BlockPlace chooses from
using AddBlocks = void (*)(const BlockSums &sums, decltype(ElementKernels::expand) expand,
                           PetscInt first, PetscInt count, const double *K, const int *chosen,
                           double *const arrays[3]);
AddBlocks add_blocks_kernel(const ReferenceElement &reference,
                            InstructionSet instructions = chosen_instruction_set());

/// The same, defined in the file that is compiled for it.
template <InstructionSet isa>
AddBlocks make_add_blocks(int dimension, int nodes);

}  // namespace trefoil
