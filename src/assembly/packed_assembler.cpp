#include "assembly/packed_assembler.hpp"

#include <petsctime.h>

#include <algorithm>

#include "support/log_events.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// The matrices of one chunk of packs, [first, first + count).
struct Chunk {
  const PackedElements &elements;
  PetscInt first = 0, count = 0;
  std::vector<double> K, N;
  std::vector<int> negative;

  explicit Chunk(const PackedElements &of) : elements(of) {
    const ElementPacks &packs = elements.elements();
    const auto matrices = static_cast<std::size_t>(PackedAssembler::chunk_of(packs) * lanes);
    K.resize(matrices * static_cast<std::size_t>(packs.entries()));
    N.resize(K.size());
    negative.resize(matrices);
  }

  /// N and the counts of negative eigenvalues from K.
  PetscErrorCode split(const double *u, TrefoilSplitStatistics *statistics) {
    PetscLogDouble begin = 0, end = 0;
    PetscFunctionBeginUser;
    PetscCall(PetscLogEventBegin(event_filter, nullptr, nullptr, nullptr, nullptr));
    PetscCall(PetscTime(&begin));
    const SplitResult result = elements.split(first, count, u, K.data(), N.data(), negative.data());
    PetscCall(PetscTime(&end));
    PetscCall(PetscLogEventEnd(event_filter, nullptr, nullptr, nullptr, nullptr));
    PetscCheck(result.status == SplitStatus::ok || result.status == SplitStatus::not_finite,
               PETSC_COMM_SELF, PETSC_ERR_LIB, "no eigenvalues of an element Hessian were found");
    statistics->filter_seconds += end - begin;
    // Without the copies that fill the last pack.
    const PetscInt left = elements.elements().elements - lanes * first;
    statistics->indefinite +=
        std::count_if(negative.begin(), negative.begin() + std::min(lanes * count, left),
                      [](int found) { return found > 0; });
    PetscFunctionReturn(PETSC_SUCCESS);
  }

  /// K += factor N. N is zero where nothing was negative.
  void add_negative(double factor) {
    const auto numbers = static_cast<std::size_t>(elements.elements().entries() * lanes * count);
    for (std::size_t k = 0; k < numbers; ++k) K[k] += factor * N[k];
  }
};

/// Calls work() for each chunk, once its matrices K are made.
template <class Work>
PetscErrorCode for_each_chunk(Chunk *chunk, const double *u, const Work &work) {
  const ElementPacks &packs = chunk->elements.elements();
  const PetscInt most = PackedAssembler::chunk_of(packs);
  PetscFunctionBeginUser;
  for (chunk->first = 0; chunk->first < packs.packs(); chunk->first += most) {
    chunk->count = std::min(most, packs.packs() - chunk->first);
    chunk->elements.hessians(chunk->first, chunk->count, u, chunk->K.data());
    PetscCall(work());
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds up H (may be null) and N (may be null) of one term's elements.
PetscErrorCode assemble_part(const PackedAssembler::Part &part, const BlockSums &sums,
                             const double *u, const PackedAssembler::Shift &shift,
                             const PackedAssembler::Wanted &wanted, double *const *H,
                             double *const *N, TrefoilSplitStatistics *statistics) {
  const PackedElements &elements = *part.elements;
  const AddBlocks add_blocks = add_blocks_kernel(*elements.elements().reference);
  const auto expand = elements.expand();
  Chunk chunk(elements);
  PetscFunctionBeginUser;
  PetscCall(for_each_chunk(&chunk, u, [&] {
    PetscFunctionBeginUser;
    const PetscInt first = chunk.first, count = chunk.count;
    if (wanted.negative_in_H != 0) {
      PetscCall(chunk.split(u, statistics));
      chunk.add_negative(wanted.negative_in_H * part.negative_factor);
    }
    if (H) add_blocks(sums, expand, first, count, chunk.K.data(), nullptr, H);
    if (!wanted.filtering || wanted.negative_in_H != 0) PetscFunctionReturn(PETSC_SUCCESS);
    if (shift) shift(elements.elements(), first, count, chunk.K.data());
    PetscCall(chunk.split(u, statistics));
    if (!N) PetscFunctionReturn(PETSC_SUCCESS);
    if (part.negative_factor != 1) {
      for (double &entry : chunk.N) entry *= part.negative_factor;
    }
    add_blocks(sums, expand, first, count, chunk.N.data(), chunk.negative.data(), N);
    PetscFunctionReturn(PETSC_SUCCESS);
  }));
  statistics->elements += elements.elements().elements;
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds H p of a pack's elements to `product`.
/// @param blocks as ElementKernels::expand writes them
/// @param node nodes x 8 local vertices
void add_product_of_pack(int dim, int nodes, const double *blocks, const PetscInt *node,
                         const double *p, double *product) {
  constexpr int most = ReferenceElement::most_nodes * 3;
  double from[most * lanes], to[most * lanes] = {};
  for (int k = 0; k < nodes * dim * lanes; ++k) {
    from[k] = p[3 * node[k / (dim * lanes) * lanes + k % lanes] + k / lanes % dim];
  }
  for (int a = 0; a < nodes; ++a) {
    for (int b = a; b < nodes; ++b) {
      for (int k = 0; k < dim * dim; ++k, blocks += lanes) {
        const int row = (dim * a + k / dim) * lanes, column = (dim * b + k % dim) * lanes;
        for (int lane = 0; lane < lanes; ++lane) {
          to[row + lane] += blocks[lane] * from[column + lane];
          if (a != b) to[column + lane] += blocks[lane] * from[row + lane];
        }
      }
    }
  }
  for (int k = 0; k < nodes * dim * lanes; ++k) {
    product[3 * node[k / (dim * lanes) * lanes + k % lanes] + k / lanes % dim] += to[k];
  }
}

}  // namespace

PetscInt PackedAssembler::chunk_of(const ElementPacks &packs) {
  constexpr PetscInt entries = 2880;  // of all of a chunk's matrices of one lane
  const PetscInt tile = tile_packs(packs.reference->nodes);
  return tile * std::max<PetscInt>(1, entries / (packs.entries() * tile));
}

PetscErrorCode PackedAssembler::set_up(const Discretization &discretization,
                                       std::span<const ElementPacks *const> packs, Mat H) {
  PetscFunctionBeginUser;
  PetscCall(blocks_.begin_placing(discretization, H));
  for (const ElementPacks *each : packs) {
    const auto same = [each](const auto &pair) { return pair.first == each; };
    if (std::any_of(sums_.begin(), sums_.end(), same)) continue;
    BlockSums &sums = sums_.emplace_back(each, BlockSums{}).second;
    PetscCall(make_block_sums(
        *each,
        [&](PetscInt row, PetscInt column, BlockPlace *place) {
          return blocks_.place(row, column, &sums.numbers, place);
        },
        &sums));
  }
  PetscCall(blocks_.end_placing());
  PetscFunctionReturn(PETSC_SUCCESS);
}

const BlockSums &PackedAssembler::sums_of(const ElementPacks &packs) const {
  return std::find_if(sums_.begin(), sums_.end(),
                      [&](const auto &pair) { return pair.first == &packs; })
      ->second;
}

double PackedAssembler::bytes() const {
  double sum = blocks_.bytes();
  for (const auto &[packs, sums] : sums_) sum += sums.bytes();
  return sum;
}

PetscErrorCode PackedAssembler::assemble(std::span<const Part> parts, const double *u,
                                         const Shift &shift, const Wanted &wanted,
                                         TrefoilSplitStatistics *statistics) const {
  const Mat H = wanted.H, N = wanted.N;
  MatrixBlocks::Target H_target, N_target;
  PetscFunctionBeginUser;
  if (H) PetscCall(blocks_.begin(H, &H_target));
  if (N) PetscCall(blocks_.begin(N, &N_target));
  for (const Part &part : parts) {
    PetscCall(assemble_part(part, sums_of(part.elements->elements()), u, shift, wanted,
                            H ? H_target.arrays : nullptr, N ? N_target.arrays : nullptr,
                            statistics));
  }
  if (H) PetscCall(blocks_.end(&H_target));
  if (N) PetscCall(blocks_.end(&N_target));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PackedAssembler::add_product(const PackedElements &elements, const double *u,
                                            const double *p, double *product) {
  const ElementPacks &packs = elements.elements();
  const int nodes = packs.reference->nodes, dim = packs.reference->dimension;
  const auto expand = elements.expand();
  const auto matrix = static_cast<std::size_t>(packs.entries() * lanes);
  std::vector<double> blocks(static_cast<std::size_t>(upper_blocks(nodes) * dim * dim * lanes));
  Chunk chunk(elements);
  PetscFunctionBeginUser;
  PetscCall(for_each_chunk(&chunk, u, [&] {
    PetscFunctionBeginUser;
    for (PetscInt k = 0; k < chunk.count; ++k) {
      expand(chunk.K.data() + matrix * static_cast<std::size_t>(k), blocks.data());
      add_product_of_pack(dim, nodes, blocks.data(),
                          &packs.nodes[static_cast<std::size_t>(nodes * lanes * (chunk.first + k))],
                          p, product);
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode PackedAssembler::count_negative(const PackedElements &elements, const double *u,
                                               std::vector<double> *counts) {
  TrefoilSplitStatistics ignored{};
  Chunk chunk(elements);
  PetscFunctionBeginUser;
  counts->clear();
  PetscCall(for_each_chunk(&chunk, u, [&] {
    PetscFunctionBeginUser;
    PetscCall(chunk.split(u, &ignored));
    counts->insert(counts->end(), chunk.negative.begin(),
                   chunk.negative.begin() + lanes * chunk.count);
    PetscFunctionReturn(PETSC_SUCCESS);
  }));
  counts->resize(
      static_cast<std::size_t>(elements.elements().elements));  // less what fills the last
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
