#pragma once

#include <petscsystypes.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "element/tet4_packs.hpp"

namespace trefoil {

/// Where a dim x dim block of a matrix lies, in one of up to three arrays: dim runs of dim numbers,
/// `stride` apart.
struct BlockPlace {
  std::int32_t code = -1;   ///< array in the two lowest bits, the rest is the first number's place
  std::int32_t stride = 3;  ///< 0: each number has a code of its own, from code >> 2 on
  [[nodiscard]] bool exists() const { return code >= 0; }
};

/// How the 3 x 3 blocks of a mesh's elements add up to the blocks of a matrix.
///
/// The elements are worked on in stretches of packs. All blocks of a stretch that belong to one
/// pair of vertices v <= w are summed in registers, and their sum is added to the matrix: as it is
/// at (v, w), transposed at (w, v). Neighbours lie in the same stretch, so the matrix is touched a
/// sixth as often as by one element after the other.
struct BlockSums {
  static constexpr PetscInt stretch = 32;  ///< packs; their blocks stay in the second-level cache

  struct Pair {
    BlockPlace upper, lower;  ///< at (v, w) and at (w, v); the latter does not exist if v = w
    std::int32_t count;       ///< blocks to sum
  };
  /// By stretch, and in it by count, so that the processor foresees where each sum ends.
  std::vector<Pair> pairs;
  /// The blocks to sum, for one pair after the other: lane + 8 (block + 10 (pack of the stretch)).
  std::vector<std::uint16_t> blocks;
  std::vector<std::size_t> first_pair, first_block;  ///< of each stretch, and one more

  /// Codes of the numbers of blocks without a stride, row by row; -1: the number does not exist.
  std::vector<std::int32_t> numbers;

  [[nodiscard]] double bytes() const;
};

/// Blocks of an element: the upper triangle (a, b), a <= b, row by row.
inline constexpr int upper_blocks = 10;

/// Finds all sums. Blocks whose place does not exist are left out.
/// @param place where block (row, column) of two local vertices lies
using PlaceOfBlock =
    std::function<PetscErrorCode(PetscInt row, PetscInt column, BlockPlace *place)>;
PetscErrorCode make_block_sums(const Tet4Packs &tets, const PlaceOfBlock &place, BlockSums *sums);

/// Expands reduced matrices of packs [first, first + count) to the elements' blocks and adds them.
/// @param first a multiple of BlockSums::stretch
/// @param K as reduced_hessians() writes it
/// @param chosen elements to add, by lane of the packs: those where it is positive; null: all
/// @param arrays what BlockPlace chooses from
using AddBlocks = void (*)(const BlockSums &sums, PetscInt first, PetscInt count, const double *K,
                           const int *chosen, double *const arrays[3]);
AddBlocks add_blocks_kernel(InstructionSet instructions = chosen_instruction_set());
template <InstructionSet isa>
AddBlocks make_add_blocks();

/// Adds one block, given row by row, or its transpose.
template <InstructionSet isa>
void add_block(const BlockSums &sums, const BlockPlace &place, bool transposed, const double *block,
               double *const arrays[3]) {
  const int across = transposed ? 3 : 1, down = transposed ? 1 : 3;
  if (place.stride > 0) {
    double *to = arrays[place.code & 3] + (place.code >> 2);
    for (int i = 0; i < 3; ++i, to += place.stride, block += down) {
      to[0] += block[0];
      to[1] += block[across];
      to[2] += block[2 * across];
    }
  } else {
    const std::int32_t *code = sums.numbers.data() + (place.code >> 2);
    for (int k = 0; k < 9; ++k) {
      if (code[k] >= 0)
        arrays[code[k] & 3][code[k] >> 2] += block[down * (k / 3) + across * (k % 3)];
    }
  }
}

}  // namespace trefoil
