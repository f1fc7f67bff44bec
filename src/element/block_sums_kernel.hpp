#pragma once

// The kernel of BlockSums. Included only by the files that are compiled for one instruction set
// each (tet4_kernels_*.cpp).

#include <cstddef>
#include <cstring>

#include "element/block_sums.hpp"

namespace trefoil {
namespace {

/// Applies the signs of the Hadamard vectors to three values: sum_k 2 h_k[a] x_k for a = 0..3.
template <class Real>
void hadamard_sums(const Real &x0, const Real &x1, const Real &x2, Real (&sums)[4]) {
  const Real sum = x1 + x2, difference = x1 - x2;
  sums[0] = x0 + sum;
  sums[1] = x0 - sum;
  sums[2] = difference - x0;
  sums[3] = -(difference + x0);
}

/// H_ab = sum_kl h_k[a] h_l[b] K_kl for a <= b, from additions only: number (i, m) of block q of
/// all lanes at blocks[8 (9 q + 3 i + m)].
template <InstructionSet isa>
void expand(const double *K, double *blocks) {
  using Real = Pack<isa>;
  for (int i = 0; i < 3; ++i) {
    for (int m = 0; m < 3; ++m) {
      Real rows[3][4];  // by column l, over the corners a
      for (int l = 0; l < 3; ++l) {
        Real x[3];
        for (int k = 0; k < 3; ++k) {
          const int r = 3 * k + i, c = 3 * l + m;
          const int entry = r >= c ? r * (r + 1) / 2 + c : c * (c + 1) / 2 + r;
          x[k] = 0.25 * Real::load(K + lanes * entry);
        }
        hadamard_sums(x[0], x[1], x[2], rows[l]);
      }
      int q = 0;
      for (int a = 0; a < 4; ++a) {
        Real block[4];
        hadamard_sums(rows[0][a], rows[1][a], rows[2][a], block);
        for (int b = a; b < 4; ++b, ++q) block[b].store(blocks + lanes * (9 * q + 3 * i + m));
      }
    }
  }
}

/// As many numbers as a register holds.
template <InstructionSet isa>
struct RegisterOf {
  using Type = double __attribute__((vector_size(16)));
};
template <>
struct RegisterOf<InstructionSet::avx2> {
  using Type = double __attribute__((vector_size(32)));
};
template <>
struct RegisterOf<InstructionSet::avx512> {
  using Type = double __attribute__((vector_size(64)));
};
template <InstructionSet isa>
using Register = typename RegisterOf<isa>::Type;
template <InstructionSet isa>
constexpr int width = sizeof(Register<isa>) / sizeof(double);

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

/// Transposes a square of as many rows as a register has numbers, rows 8 apart.
template <InstructionSet isa>
void transpose_square(const double *from, double *to) {
  using R = Register<isa>;
  constexpr int n = width<isa>;
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
  for (int i = 0; i < n; ++i) store(s[i], to + lanes * i);
}

/// The blocks of a stretch, block by block: eight numbers of each together, the ninth apart.
struct StretchBlocks {
  static constexpr int count = BlockSums::stretch * upper_blocks * lanes;
  alignas(64) double first_eight[8 * count];
  alignas(64) double ninth[count];
};

template <InstructionSet isa>
void expand_pack(const double *K, PetscInt pack, StretchBlocks *stretch) {
  alignas(64) double blocks[upper_blocks * 9 * lanes];
  expand<isa>(K, blocks);
  double *eight = stretch->first_eight + 8 * upper_blocks * lanes * pack;
  double *ninth = stretch->ninth + upper_blocks * lanes * pack;
  for (int q = 0; q < upper_blocks; ++q, eight += 8 * lanes, ninth += lanes) {
    const double *block = blocks + 9 * lanes * q;
    for (int i = 0; i < 8; i += width<isa>) {
      for (int lane = 0; lane < lanes; lane += width<isa>) {
        transpose_square<isa>(block + lanes * i + lane, eight + 8 * lane + i);
      }
    }
    Pack<isa>::load(block + 8 * lanes).store(ninth);
  }
}

bool any(const int *chosen, PetscInt count) {
  bool result = false;
  for (PetscInt i = 0; i < count; ++i) result = result || chosen[i] > 0;
  return result;
}

/// K where an element is chosen, else 0, also in the place of what is not finite.
template <InstructionSet isa>
void choose(const double *K, const int *chosen, double *result) {
  double wanted[lanes];
  for (int lane = 0; lane < lanes; ++lane) wanted[lane] = chosen[lane];
  const auto mask = Pack<isa>::load(wanted).v > 0;
  for (int entry = 0; entry < reduced_entries; ++entry) {
    const auto value = Pack<isa>::load(K + lanes * entry).v;
    Pack<isa>(mask ? value : Pack<isa>().v).store(result + lanes * entry);
  }
}

/// Sums on the way while the places of one are fetched from memory.
constexpr std::ptrdiff_t ahead = 8;

void prefetch(const BlockPlace &place, double *const arrays[3]) {
  if (!place.exists()) return;
  const double *to = arrays[place.code & 3] + (place.code >> 2);
  for (int i = 0; i < 3; ++i) __builtin_prefetch(to + i * place.stride, 1);
}

template <InstructionSet isa>
void add_stretch(const BlockSums &sums, std::size_t number, const StretchBlocks &blocks,
                 double *const arrays[3]) {
  using R = Register<isa>;
  constexpr int parts = 8 / width<isa>;
  const std::uint16_t *source = sums.blocks.data() + sums.first_block[number];
  const BlockSums::Pair *pair = sums.pairs.data() + sums.first_pair[number];
  const BlockSums::Pair *end = sums.pairs.data() + sums.first_pair[number + 1];
  for (; pair != end; ++pair) {
    if (end - pair > ahead) {
      prefetch(pair[ahead].upper, arrays);
      prefetch(pair[ahead].lower, arrays);
    }
    alignas(64) double total[9];
    R sum[parts] = {};
    double last = 0;
    for (std::int32_t i = 0; i < pair->count; ++i, ++source) {
      const double *eight = blocks.first_eight + 8 * *source;
      for (int p = 0; p < parts; ++p) sum[p] = sum[p] + load<R>(eight + width<isa> * p);
      last += blocks.ninth[*source];
    }
    for (int p = 0; p < parts; ++p) store(sum[p], total + width<isa> * p);
    total[8] = last;
    add_block<isa>(sums, pair->upper, false, total, arrays);
    if (pair->lower.exists()) add_block<isa>(sums, pair->lower, true, total, arrays);
  }
}

template <InstructionSet isa>
void add_packed_blocks(const BlockSums &sums, PetscInt first, PetscInt count, const double *K,
                       const int *chosen, double *const arrays[3]) {
  StretchBlocks blocks;
  for (PetscInt begin = 0; begin < count; begin += BlockSums::stretch) {
    const PetscInt left = count - begin;
    const PetscInt packs = left < BlockSums::stretch ? left : BlockSums::stretch;
    if (chosen && !any(chosen + lanes * begin, lanes * packs)) continue;
    for (PetscInt pack = begin; pack < begin + packs; ++pack) {
      alignas(64) double chosen_K[reduced_entries * lanes];
      const double *all = K + reduced_entries * lanes * pack;
      if (chosen) choose<isa>(all, chosen + lanes * pack, chosen_K);
      expand_pack<isa>(chosen ? chosen_K : all, pack - begin, &blocks);
    }
    add_stretch<isa>(sums, static_cast<std::size_t>((first + begin) / BlockSums::stretch), blocks,
                     arrays);
  }
}

}  // namespace

template <InstructionSet isa>
AddBlocks make_add_blocks() {
  return add_packed_blocks<isa>;
}

}  // namespace trefoil
