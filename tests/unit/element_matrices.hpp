#pragma once

// Element matrices at random and the sums that they have to come to, for the tests of the element
// hook. Every rank knows all elements and adds its share of them, whoever owns the rows.

#include <gtest/gtest.h>
#include <petscmat.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "filter/filter.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil::test {

using Dense = std::vector<double>;

inline PetscMPIInt rank_of_world() {
  PetscMPIInt rank = 0;
  EXPECT_EQ(MPI_Comm_rank(PETSC_COMM_WORLD, &rank), MPI_SUCCESS);
  return rank;
}

inline PetscMPIInt size_of_world() {
  PetscMPIInt size = 0;
  EXPECT_EQ(MPI_Comm_size(PETSC_COMM_WORLD, &size), MPI_SUCCESS);
  return size;
}

struct Element {
  std::vector<PetscInt> nodes;  ///< -1: left out
  Dense H;                      ///< all unknowns of a node after each other
};

enum class Kind { positive, mixed };

/// Elements of two to four nodes among `nodes` of them, with `block` unknowns each.
struct Elements {
  PetscInt nodes = 14, block = 1;
  std::vector<Element> all;

  Elements(PetscInt unknowns_of_a_node, Kind kind, unsigned seed = 1) : block(unknowns_of_a_node) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    std::vector<PetscInt> order(static_cast<std::size_t>(nodes));
    for (PetscInt i = 0; i < nodes; ++i) order[static_cast<std::size_t>(i)] = i;
    for (int e = 0; e < 40; ++e) {
      std::shuffle(order.begin(), order.end(), engine);
      Element element;
      element.nodes.assign(order.begin(), order.begin() + 2 + e % 3);
      if (e % 5 == 0) element.nodes[static_cast<std::size_t>(e % 2)] = -1;
      const std::size_t n = element.nodes.size() * static_cast<std::size_t>(block);
      Dense B(n * n);
      for (double &value : B) value = normal(engine);
      element.H.assign(n * n, 0);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < n; ++j) {
          // B + B' has eigenvalues of both signs, B B' has not.
          element.H[n * i + j] = B[n * i + j] + B[n * j + i];
          if (kind == Kind::mixed && e % 3 != 0) continue;
          element.H[n * i + j] = 0;
          for (std::size_t k = 0; k < n; ++k) element.H[n * i + j] += B[n * i + k] * B[n * j + k];
        }
      }
      all.push_back(element);
    }
  }

  [[nodiscard]] PetscInt unknowns() const { return nodes * block; }

  /// The elements that this rank adds.
  [[nodiscard]] std::vector<Element> mine() const {
    std::vector<Element> share;
    const auto size = static_cast<std::size_t>(size_of_world());
    for (auto e = static_cast<std::size_t>(rank_of_world()); e < all.size(); e += size) {
      share.push_back(all[e]);
    }
    return share;
  }

  /// Numbers of an element's unknowns.
  [[nodiscard]] std::vector<PetscInt> index(const Element &element) const {
    std::vector<PetscInt> numbers;
    for (const PetscInt node : element.nodes) {
      for (PetscInt c = 0; c < block; ++c) numbers.push_back(node < 0 ? -1 : block * node + c);
    }
    return numbers;
  }

  [[nodiscard]] int indefinite() const {
    int count = 0;
    for (const Element &element : all) count += split_of(element).second > 0;
    return count;
  }

  static std::pair<Dense, int> split_of(const Element &element) {
    Dense N(element.H.size());
    int negative = 0;
    const auto n = static_cast<int>(std::lround(std::sqrt(static_cast<double>(N.size()))));
    EXPECT_EQ(split(n, 1, element.H.data(), N.data(), &negative).status, SplitStatus::ok);
    return {N, negative};
  }

  /// The sum of H_e + 2 w N_e, entry by entry.
  [[nodiscard]] Dense sum(double weight) const {
    const auto size = static_cast<std::size_t>(unknowns());
    Dense total(size * size, 0);
    for (const Element &element : all) {
      const Dense N = split_of(element).first;
      const std::vector<PetscInt> numbers = index(element);
      for (std::size_t i = 0; i < numbers.size(); ++i) {
        for (std::size_t j = 0; j < numbers.size(); ++j) {
          if (numbers[i] < 0 || numbers[j] < 0) continue;
          const std::size_t at = numbers.size() * i + j;
          total[size * static_cast<std::size_t>(numbers[i]) +
                static_cast<std::size_t>(numbers[j])] += element.H[at] + 2 * weight * N[at];
        }
      }
    }
    return total;
  }
};

/// How a host adds its elements.
enum class Way { values, blocked, local, blocked_local };

/// A Mat of a type, with room for anything and a numbering of its own on each rank: backwards.
inline PetscErrorCode make_matrix(const std::string &type, PetscInt nodes, PetscInt block,
                                  Mat *matrix) {
  PetscInt local = PETSC_DECIDE;
  ISLocalToGlobalMapping mapping = nullptr;
  PetscBool symmetric = PETSC_FALSE;
  PetscFunctionBeginUser;
  PetscCall(PetscSplitOwnership(PETSC_COMM_WORLD, &local, &nodes));
  PetscCall(MatCreate(PETSC_COMM_WORLD, matrix));
  PetscCall(MatSetSizes(*matrix, local * block, local * block, nodes * block, nodes * block));
  PetscCall(MatSetBlockSize(*matrix, block));
  PetscCall(MatSetType(*matrix, type.c_str()));
  PetscCall(MatSeqAIJSetPreallocation(*matrix, nodes * block, nullptr));
  PetscCall(MatMPIAIJSetPreallocation(*matrix, local * block, nullptr, nodes * block, nullptr));
  PetscCall(MatSeqBAIJSetPreallocation(*matrix, block, nodes, nullptr));
  PetscCall(MatMPIBAIJSetPreallocation(*matrix, block, local, nullptr, nodes, nullptr));
  PetscCall(MatSeqSBAIJSetPreallocation(*matrix, block, nodes, nullptr));
  PetscCall(MatMPISBAIJSetPreallocation(*matrix, block, local, nullptr, nodes, nullptr));
  PetscCall(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(*matrix), &symmetric,
                                      MATSEQSBAIJ, MATMPISBAIJ, ""));
  if (symmetric) PetscCall(MatSetOption(*matrix, MAT_IGNORE_LOWER_TRIANGULAR, PETSC_TRUE));
  // Hosts ask for this one where they zero rows, lest the pattern shrinks.
  PetscCall(MatSetOption(*matrix, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE));
  std::vector<PetscInt> backwards;
  for (PetscInt node = nodes; node-- > 0;) backwards.push_back(node);
  PetscCall(ISLocalToGlobalMappingCreate(PETSC_COMM_WORLD, block, nodes, backwards.data(),
                                         PETSC_COPY_VALUES, &mapping));
  PetscCall(MatSetLocalToGlobalMapping(*matrix, mapping, mapping));
  PetscCall(ISLocalToGlobalMappingDestroy(&mapping));
  PetscFunctionReturn(PETSC_SUCCESS);
}

inline PetscErrorCode add_element(Mat matrix, const Elements &elements, const Element &element,
                                  Way way) {
  std::vector<PetscInt> nodes = element.nodes;
  const bool local = way == Way::local || way == Way::blocked_local;
  PetscFunctionBeginUser;
  for (PetscInt &node : nodes) {
    if (local && node >= 0) node = elements.nodes - 1 - node;
  }
  const std::vector<PetscInt> index = elements.index({nodes, {}});
  const auto m = static_cast<PetscInt>(nodes.size()), n = static_cast<PetscInt>(index.size());
  const double *H = element.H.data();
  switch (way) {
    case Way::values:
      PetscCall(MatSetValues(matrix, n, index.data(), n, index.data(), H, ADD_VALUES));
      break;
    case Way::blocked:
      PetscCall(MatSetValuesBlocked(matrix, m, nodes.data(), m, nodes.data(), H, ADD_VALUES));
      break;
    case Way::local:
      PetscCall(MatSetValuesLocal(matrix, n, index.data(), n, index.data(), H, ADD_VALUES));
      break;
    case Way::blocked_local:
      PetscCall(MatSetValuesBlockedLocal(matrix, m, nodes.data(), m, nodes.data(), H, ADD_VALUES));
      break;
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

inline PetscErrorCode finish_assembly(Mat matrix) {
  PetscFunctionBeginUser;
  PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// What a host's Jacobian callback does: this rank's elements, and the end of the assembly.
inline PetscErrorCode add_elements(Mat matrix, const Elements &elements, Way way) {
  PetscFunctionBeginUser;
  for (const Element &element : elements.mine()) {
    PetscCall(add_element(matrix, elements, element, way));
  }
  PetscCall(finish_assembly(matrix));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// The whole matrix on every rank; of a symmetric type both triangles.
inline Dense dense(Mat matrix) {
  PetscInt begin = 0, end = 0, n = 0;
  PetscBool symmetric = PETSC_FALSE;
  EXPECT_EQ(MatGetSize(matrix, &n, nullptr), 0);
  EXPECT_EQ(MatGetOwnershipRange(matrix, &begin, &end), 0);
  EXPECT_EQ(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(matrix), &symmetric,
                                      MATSEQSBAIJ, MATMPISBAIJ, ""),
            0);
  Dense values(static_cast<std::size_t>(n * n), 0);
  for (PetscInt row = begin; row < end; ++row) {
    for (PetscInt column = symmetric ? row : 0; column < n; ++column) {
      double value = 0;
      if (MatGetValues(matrix, 1, &row, 1, &column, &value) != 0) return {};
      values[static_cast<std::size_t>(n * row + column)] = value;
      if (symmetric) values[static_cast<std::size_t>(n * column + row)] = value;
    }
  }
  EXPECT_EQ(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE,
                          MPI_SUM, PETSC_COMM_WORLD),
            MPI_SUCCESS);
  return values;
}

/// The largest difference of two matrices over the largest entry of the second.
inline double difference(const Dense &a, const Dense &b) {
  double largest = 0, off = 0;
  if (a.size() != b.size()) return INFINITY;
  for (std::size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(b[i]));
    off = std::max(off, std::abs(a[i] - b[i]));
    if (!std::isfinite(a[i])) return INFINITY;
  }
  return off / (largest > 0 ? largest : 1);
}

}  // namespace trefoil::test
