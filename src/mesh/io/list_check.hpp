#pragma once

#include <petscsystypes.h>

#include <bit>
#include <cstdint>
#include <span>
#include <type_traits>

#include "support/split_mix.hpp"

namespace trefoil {

/// Of a list's entries from number `first` on: a number that tells them from others. That of a list
/// is the sum of those of its parts, modulo 2^64, so ranks can share it.
template <class Number>
std::uint64_t check_of_entries(PetscInt64 first, std::span<const Number> entries) {
  std::uint64_t sum = 0;
  auto place = static_cast<std::uint64_t>(first);
  for (const Number entry : entries) {
    std::uint64_t bits = 0;
    if constexpr (std::is_floating_point_v<Number>) {
      bits = std::bit_cast<std::uint64_t>(entry);
    } else {
      bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(entry));
    }
    sum += mixed(bits ^ mixed(place++));
  }
  return sum;
}

/// What a file keeps of it: 31 bits, which every PetscInt has.
inline PetscInt kept_check(std::uint64_t sum) {
  return static_cast<PetscInt>(sum >> 33);
}

}  // namespace trefoil
