#pragma once

namespace trefoil {

/// What one core of this machine can do now, measured in a tenth of a second each.
struct MachinePeak {
  double flops_per_second;  ///< multiply-adds of doubles in registers, two each, by the same
                            ///< instruction set as the kernels
  double bytes_per_second;  ///< a = b + s c over arrays beyond every cache, three numbers moved
};
MachinePeak measure_machine_peak();

}  // namespace trefoil
