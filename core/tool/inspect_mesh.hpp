// What `springnet inspect` tells of a mesh file.
#pragma once

#include <filesystem>

namespace springnet::tool {

// Prints it; throws Error(input) for a file that cannot be read.
void inspect_mesh(const std::filesystem::path& file, bool json);

}  // namespace springnet::tool
