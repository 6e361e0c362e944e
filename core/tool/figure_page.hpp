// A page with figures that shows the values at the pointer.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "figure/figure.hpp"

namespace springnet::tool {

// Throws Error(input) unless the name of --plot's file ends in .svg or .html.
void require_ending(const std::filesystem::path& file);
// A picture, or a page, by the ending.
void write_figures(const std::filesystem::path& file, const std::string& title,
                   const std::vector<figure::Figure>& figures);

// It loads nothing. Axes are linear.
[[nodiscard]] std::string page_of(const std::string& title, const std::vector<figure::Figure>& figures);

// The same for the end of a page that has the colours of figure::embedded_style.
[[nodiscard]] std::string part_of_page(const std::vector<figure::Figure>& figures);

}  // namespace springnet::tool
