#pragma once

#include <petscsystypes.h>

#include <bit>
#include <cstdint>
#include <span>

namespace trefoil {

/// Of a list's entries from number `first` on: a number that tells them from others. That of a list
/// is the sum of those of its parts, modulo 2^64, so ranks can share it. The mixing of each entry
/// with its place is that of SplitMix64 [Steele, Lea, Flood 2014].
template <class Number>
std::uint64_t check_of_entries(PetscInt64 first, std::span<const Number> entries) {
  const auto mixed = [](std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  };
  std::uint64_t sum = 0;
  auto place = static_cast<std::uint64_t>(first);
  for (const Number entry : entries) {
    std::uint64_t bits = 0;
    if constexpr (sizeof(Number) == sizeof(double) && Number(0.5) != 0) {
      bits = std::bit_cast<std::uint64_t>(entry);
    } else {
      bits = static_cast<std::uint64_t>(static_cast<std::int64_t>(entry));
    }
    sum += mixed(bits + mixed(++place * 0x9e3779b97f4a7c15));
  }
  return sum;
}

/// What a file keeps of it: 31 bits, which every PetscInt has.
inline PetscInt kept_check(std::uint64_t sum) {
  return static_cast<PetscInt>(sum >> 33);
}

}  // namespace trefoil
