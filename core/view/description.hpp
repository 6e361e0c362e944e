// What a page says of a run in words and single numbers.
#pragma once

#include <string>

#include "view/content.hpp"

namespace springnet::view {

// JSON that may stand in a script element.
[[nodiscard]] std::string describe(const Content& content, bool rounded);

}  // namespace springnet::view
