#pragma once

// The kernel of BlockSums. Included only by the files that are compiled for one instruction set
// each (block_sums_kernel_*.cpp).

#include <cstddef>
#include <cstring>

#include "assembly/block_sums.hpp"

namespace trefoil {
namespace {

/// Two, four or eight numbers in a register. (gcc 12 makes no vectors of dependent size.)
template <int numbers>
struct RegisterOf;
template <>
struct RegisterOf<2> {
  using Type = double __attribute__((vector_size(16)));
};
template <>
struct RegisterOf<4> {
  using Type = double __attribute__((vector_size(32)));
};
template <>
struct RegisterOf<8> {
  using Type = double __attribute__((vector_size(64)));
};
template <int numbers>
using Register = typename RegisterOf<numbers>::Type;

/// Numbers that a register holds.
template <InstructionSet isa>
constexpr int width = isa == InstructionSet::avx512 ? 8
                      : isa == InstructionSet::avx2 ? 4
                                                    : 2;

template <class R>
R load(const double *from) {
  R result;
  std::memcpy(&result, from, sizeof(R));
  return result;
}
template <class R>
void store(const R &value, double *to) {
  std::memcpy(to, &value, sizeof(R));
}

/// Transposes a square of n x n numbers, rows `lanes` apart, into one with rows `to_row` apart.
template <int n>
void transpose_square(const double *from, double *to, int to_row) {
  using R = Register<n>;
  R r[n], s[n];
  for (int i = 0; i < n; ++i) r[i] = load<R>(from + lanes * i);
  if constexpr (n == 2) {
    s[0] = __builtin_shufflevector(r[0], r[1], 0, 2);
    s[1] = __builtin_shufflevector(r[0], r[1], 1, 3);
  } else if constexpr (n == 4) {
    R t[n];
    for (int i = 0; i < n; i += 2) {
      t[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 4, 2, 6);
      t[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 1, 5, 3, 7);
    }
    for (int i = 0; i < 2; ++i) {
      s[i] = __builtin_shufflevector(t[i], t[i + 2], 0, 1, 4, 5);
      s[i + 2] = __builtin_shufflevector(t[i], t[i + 2], 2, 3, 6, 7);
    }
  } else {
    R t[n];
    for (int i = 0; i < n; i += 2) {
      s[i] = __builtin_shufflevector(r[i], r[i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
      s[i + 1] = __builtin_shufflevector(r[i], r[i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    for (int half = 0; half < n; half += 4) {
      for (int i = half; i < half + 2; ++i) {
        t[i] = __builtin_shufflevector(s[i], s[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        t[i + 2] = __builtin_shufflevector(s[i], s[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
      }
    }
    for (int i = 0; i < 4; ++i) {
      s[i] = __builtin_shufflevector(t[i], t[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
      s[i + 4] = __builtin_shufflevector(t[i], t[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
  }
  for (int i = 0; i < n; ++i) store(s[i], to + to_row * i);
}

bool any(const int *chosen, PetscInt count) {
  bool result = false;
  for (PetscInt i = 0; i < count; ++i) result = result || chosen[i] > 0;
  return result;
}

/// Sums on the way while the places of one are fetched from memory.
constexpr std::ptrdiff_t ahead = 8;

template <int dim, int nodes, InstructionSet isa>
struct Adder {
  static constexpr int upper = upper_blocks(nodes), numbers = dim * dim;
  static constexpr int rows = dim * (nodes - 1), entries = rows * (rows + 1) / 2;
  /// Numbers of a block that lie together, in whole registers; of nine the last lies apart.
  static constexpr int together = dim == 3 ? 8 : 4;
  static constexpr int part = width<isa> < together ? width<isa> : together;
  static constexpr int parts = together / part;
  static constexpr PetscInt tile = tile_packs(nodes);

  /// The blocks of a tile, block by block.
  struct TileBlocks {
    static constexpr int count = tile * upper * lanes;
    alignas(64) double first[together * count];
    alignas(64) double last[dim == 3 ? count : 1];
  };

  static void expand_pack(decltype(ElementKernels::expand) expand, const double *K, PetscInt pack,
                          TileBlocks *tile_blocks) {
    alignas(64) double blocks[upper * numbers * lanes];
    expand(K, blocks);
    const PetscInt begin = upper * lanes * pack;
    for (int q = 0; q < upper; ++q) {
      const double *block = blocks + numbers * lanes * q;
      double *first = tile_blocks->first + together * (begin + lanes * q);
      for (int i = 0; i < together; i += part) {
        for (int lane = 0; lane < lanes; lane += part) {
          transpose_square<part>(block + lanes * i + lane, first + together * lane + i, together);
        }
      }
      if constexpr (dim == 3) {
        Pack<isa>::load(block + 8 * lanes).store(tile_blocks->last + begin + lanes * q);
      }
    }
  }

  /// K where an element is chosen, else 0, also in the place of what is not finite.
  static void choose(const double *K, const int *chosen, double *result) {
    double wanted[lanes];
    for (int lane = 0; lane < lanes; ++lane) wanted[lane] = chosen[lane];
    const auto mask = Pack<isa>::load(wanted).v > 0;
    for (int entry = 0; entry < entries; ++entry) {
      const auto value = Pack<isa>::load(K + lanes * entry).v;
      Pack<isa>(mask ? value : Pack<isa>().v).store(result + lanes * entry);
    }
  }

  static void prefetch(const BlockPlace &place, double *const arrays[3]) {
    if (!place.exists()) return;
    const double *to = arrays[place.code & 3] + (place.code >> 2);
    for (int i = 0; i < dim; ++i) __builtin_prefetch(to + i * place.stride, 1);
  }

  /// Adds one block, given row by row, or its transpose.
  static void add_block(const BlockSums &sums, const BlockPlace &place, bool transposed,
                        const double *block, double *const arrays[3]) {
    const int across = transposed ? dim : 1, down = transposed ? 1 : dim;
    if (place.stride > 0) {
      double *to = arrays[place.code & 3] + (place.code >> 2);
      for (int i = 0; i < dim; ++i, to += place.stride, block += down) {
        for (int k = 0; k < dim; ++k) to[k] += block[across * k];
      }
    } else {
      const std::int32_t *code = sums.numbers.data() + (place.code >> 2);
      for (int k = 0; k < numbers; ++k) {
        if (code[k] < 0) continue;
        arrays[code[k] & 3][code[k] >> 2] += block[down * (k / dim) + across * (k % dim)];
      }
    }
  }

  static void add_tile(const BlockSums &sums, std::size_t number, const TileBlocks &blocks,
                       double *const arrays[3]) {
    using R = Register<part>;
    const std::uint16_t *source = sums.blocks.data() + sums.first_block[number];
    const BlockSums::Pair *pair = sums.pairs.data() + sums.first_pair[number];
    const BlockSums::Pair *end = sums.pairs.data() + sums.first_pair[number + 1];
    for (; pair != end; ++pair) {
      if (end - pair > ahead) {
        prefetch(pair[ahead].upper, arrays);
        prefetch(pair[ahead].lower, arrays);
      }
      alignas(64) double total[together + 1];
      R sum[parts] = {};
      double last = 0;
      for (std::int32_t i = 0; i < pair->count; ++i, ++source) {
        const double *first = blocks.first + together * *source;
        for (int p = 0; p < parts; ++p) sum[p] = sum[p] + load<R>(first + part * p);
        if constexpr (dim == 3) last += blocks.last[*source];
      }
      for (int p = 0; p < parts; ++p) store(sum[p], total + part * p);
      total[together] = last;
      add_block(sums, pair->upper, false, total, arrays);
      if (pair->lower.exists()) add_block(sums, pair->lower, true, total, arrays);
    }
  }

  static void add_blocks(const BlockSums &sums, decltype(ElementKernels::expand) expand,
                         PetscInt first, PetscInt count, const double *K, const int *chosen,
                         double *const arrays[3]) {
    TileBlocks blocks;
    for (PetscInt begin = 0; begin < count; begin += tile) {
      const PetscInt packs = count - begin < tile ? count - begin : tile;
      if (chosen && !any(chosen + lanes * begin, lanes * packs)) continue;
      for (PetscInt pack = begin; pack < begin + packs; ++pack) {
        alignas(64) double chosen_K[entries * lanes];
        const double *all = K + entries * lanes * pack;
        if (chosen) choose(all, chosen + lanes * pack, chosen_K);
        expand_pack(expand, chosen ? chosen_K : all, pack - begin, &blocks);
      }
      add_tile(sums, static_cast<std::size_t>((first + begin) / tile), blocks, arrays);
    }
  }
};

}  // namespace

template <InstructionSet isa>
AddBlocks make_add_blocks(int dimension, int nodes) {
  if (dimension == 2) {
    return nodes == 3 ? Adder<2, 3, isa>::add_blocks : Adder<2, 6, isa>::add_blocks;
  }
  return nodes == 4 ? Adder<3, 4, isa>::add_blocks : Adder<3, 10, isa>::add_blocks;
}

}  // namespace trefoil
