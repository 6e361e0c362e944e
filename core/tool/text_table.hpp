// Aligned columns of text for a terminal.
#pragma once

#include <string>
#include <vector>

namespace springnet::tool {

// Pads each cell to the widest of its column, with two spaces between; the last column is not padded.
[[nodiscard]] std::string align_columns(const std::vector<std::vector<std::string>>& rows, std::size_t indent = 2);

}  // namespace springnet::tool
