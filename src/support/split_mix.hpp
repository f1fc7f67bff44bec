#pragma once

#include <cmath>
#include <cstdint>

namespace trefoil {

/// SplitMix64 [Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators"]:
/// neighbouring numbers become such as have nothing to do with each other.
inline std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

/// Of a number one between -1 and 1, always the same.
inline double random_number(std::int64_t i) {
  return std::ldexp(static_cast<double>(mixed(static_cast<std::uint64_t>(i)) >> 11), -52) - 1;
}

}  // namespace trefoil
