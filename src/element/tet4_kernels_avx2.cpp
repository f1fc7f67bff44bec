// Compiled for one instruction set, see CMakeLists.txt. A new material is one line.
#include "element/tet4_kernels.hpp"
#include "material/stable_neo_hookean.hpp"

namespace trefoil {

template Tet4Kernels<StableNeoHookean> make_tet4_kernels<StableNeoHookean, InstructionSet::avx2>();

template AddBlocks make_add_blocks<InstructionSet::avx2>();

}  // namespace trefoil
