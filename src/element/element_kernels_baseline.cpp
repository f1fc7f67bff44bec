// Compiled for one instruction set, see CMakeLists.txt.
#include "element/mean_volume_kernels.hpp"

namespace trefoil {

template ElementKernels make_element_kernels<InstructionSet::baseline>(int dimension, int nodes,
                                                                       ElementPressure pressure);

}  // namespace trefoil
