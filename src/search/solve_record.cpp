#include "search/solve_record.hpp"

namespace trefoil {

void SolveRecord::begin() {
  const double kept_head_start = head_start;
  const double weight = current.weight;  // of the Jacobian, which a SNES may keep
  *this = {};
  head_start = kept_head_start;
  current.weight = weight;
  running = true;
  clock.start(Phase::assembly);  // the first residual
}

const IterationRecord *SolveRecord::last_lesson() const {
  for (auto entry = history.rbegin(); entry != history.rend(); ++entry) {
    if (!entry->truncated) return &*entry;
  }
  return nullptr;
}

}  // namespace trefoil
