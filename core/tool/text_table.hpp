// Columns of text for a terminal.
#pragma once

#include <string>
#include <vector>

namespace springnet::tool {

// Each cell as wide as the widest of its column, two spaces between; the last column is not filled up.
[[nodiscard]] std::string align_columns(const std::vector<std::vector<std::string>>& rows, std::size_t indent = 2);

}  // namespace springnet::tool
