// The springs of a network as a table, for values that a program or a spreadsheet gives to each of them.
#pragma once

#include <filesystem>

#include <springnet/network.hpp>

namespace springnet::tool {

// Columns spring, first, second, x, y, z and rest_length: the number of a spring, those of its ends, where its middle
// is at the start and its rest length, m. Throws Error(input) if the file cannot be written.
void write_springs(const std::filesystem::path& file, const Network& network);

}  // namespace springnet::tool
