#include "filter/packed_filter.hpp"

namespace trefoil {

template <>
SplitResult split_packs_of<4>(int, const double *, double *, int *,
                              ReducedSplitExperiment &) noexcept;
template <>
SplitResult split_packs_of<10>(int, const double *, double *, int *,
                               ReducedSplitExperiment &) noexcept;
template <>
SplitResult split_packs_of<27>(int, const double *, double *, int *,
                               ReducedSplitExperiment &) noexcept;

SplitResult split_packed(int n, int packs, const double *K, double *N, int *negative,
                         ReducedSplitExperiment &experiment) noexcept {
  switch (n) {
    case 4:
      return split_packs_of<4>(packs, K, N, negative, experiment);
    case reduced_rows:
      return split_reduced(packs, K, N, negative, experiment);
    case 10:
      return split_packs_of<10>(packs, K, N, negative, experiment);
    case 27:
      return split_packs_of<27>(packs, K, N, negative, experiment);
    default:
      SplitResult result;
      result.status = SplitStatus::bad_size;
      return result;
  }
}

SplitResult split_packed(int n, int packs, const double *K, double *N, int *negative) noexcept {
  ReducedSplitExperiment experiment;
  experiment.instructions = chosen_instruction_set();
  return split_packed(n, packs, K, N, negative, experiment);
}

}  // namespace trefoil
