// Compiled for one instruction set, see CMakeLists.txt.
#include "assembly/block_sums_kernel.hpp"

namespace trefoil {

template AddBlocks make_add_blocks<InstructionSet::avx512>(int dimension, int nodes);

}  // namespace trefoil
