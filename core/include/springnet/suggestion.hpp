#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <springnet/export.hpp>

namespace springnet {

// Of `known`, the one or more names nearest to `name` by edit distance, as "did you mean 'a' or 'b'?"; empty if
// nothing is near.
[[nodiscard]] SPRINGNET_API std::string suggestion(std::string_view name, const std::vector<std::string>& known);

}  // namespace springnet
