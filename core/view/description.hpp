// The words and single numbers of a page.
#pragma once

#include <string>
#include <vector>

#include "view/content.hpp"

namespace springnet::view {

// JSON that is safe in a script element. motions: titles of all that the page has.
[[nodiscard]] std::string describe(const Content& content, bool rounded, const std::vector<std::string>& motions);

}  // namespace springnet::view
