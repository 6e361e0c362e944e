// A page with figures that shows the values at the pointer.
#pragma once

#include <string>
#include <vector>

#include "figure/figure.hpp"

namespace springnet::tool {

// It loads nothing. Axes are linear.
[[nodiscard]] std::string page_of(const std::string& title, const std::vector<figure::Figure>& figures);

// The same for the end of a page that has the colours of figure::embedded_style.
[[nodiscard]] std::string part_of_page(const std::vector<figure::Figure>& figures);

}  // namespace springnet::tool
