#pragma once

#include <unistd.h>

#include <cstdlib>

namespace trefoil {

/// Starts the program anew unless LAPACK is told how many threads to take: its library reads this
/// before main() begins.
inline void keep_lapack_to_one_thread(char **arguments) {
  if (std::getenv("OPENBLAS_NUM_THREADS")) return;
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  execv("/proc/self/exe", arguments);
}

}  // namespace trefoil
