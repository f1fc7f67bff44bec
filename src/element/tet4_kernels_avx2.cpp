// Compiled for one instruction set, see CMakeLists.txt.
#include "element/block_sums_kernel.hpp"
#include "element/tet4_kernels.hpp"

namespace trefoil {

template Tet4Kernels make_tet4_kernels<InstructionSet::avx2>();
template AddBlocks make_add_blocks<InstructionSet::avx2>();

}  // namespace trefoil
