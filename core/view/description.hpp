// The words and single numbers of a page.
#pragma once

#include <string>

#include "view/content.hpp"

namespace springnet::view {

// JSON that is safe in a script element.
[[nodiscard]] std::string describe(const Content& content, bool rounded);

}  // namespace springnet::view
