#pragma once

#include <string>
#include <vector>

namespace trefoil {

/// Reads a file of options in PETSc's own format, "-name value" a line, # for comments, into words
/// of a command line. PETSc itself would read it inside PetscInitialize on the first rank alone,
/// and leave the others waiting for ever where it cannot. (Aliases are refused.)
/// @throws InputError with the file's name, the line, and the way out
std::vector<std::string> read_option_lines(const std::string &path);

}  // namespace trefoil
