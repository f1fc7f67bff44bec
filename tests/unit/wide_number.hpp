#pragma once

// Numbers of more than twice the digits, for references.

#if defined(__x86_64__)
#include <quadmath.h>

namespace trefoil::test {
using Wide = __float128;
inline Wide square_root(Wide x) {
  return sqrtq(x);
}
inline Wide wide_log(Wide x) {
  return logq(x);
}
}  // namespace trefoil::test

#else
#include <cmath>

namespace trefoil::test {
using Wide = long double;  // of 113 bits on other 64-bit processors
inline Wide square_root(Wide x) {
  return std::sqrt(x);
}
inline Wide wide_log(Wide x) {
  return std::log(x);
}
}  // namespace trefoil::test
#endif
