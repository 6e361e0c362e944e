// What `springnet inspect` reports about a mesh file.
#pragma once

#include <filesystem>

namespace springnet::tool {

// Prints the report. Throws Error(input) if the file cannot be read.
void inspect_mesh(const std::filesystem::path& file, bool json);

}  // namespace springnet::tool
