#pragma once

#include <string>
#include <string_view>

namespace trefoil {

/// Whether a file's name is that of a format that is not read.
bool has_foreign_name(const std::string &path);

/// What to say of a file that is in none of the formats that are read: a sentence's end that says,
/// where its name or its beginning tells, which format it is in, and how it is converted.
std::string advice_on_format(const std::string &path, std::string_view beginning);

}  // namespace trefoil
