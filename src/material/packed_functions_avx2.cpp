// Compiled for one instruction set, see CMakeLists.txt.
#include "material/packed_functions_table.hpp"

template const trefoil::PackedFunctions *
trefoil::packed_functions_table<trefoil::InstructionSet::avx2>();
