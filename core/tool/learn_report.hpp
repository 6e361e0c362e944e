// What a search has found, for the terminal and the page.
#pragma once

#include <string>

#include <springnet/learn.hpp>

namespace springnet::tool {

// What was learned, how well it describes what was observed, a row for each variable, and the notes.
// rest_in: the file that has what finds no room here.
[[nodiscard]] std::string report_of(const LearnedNet& learned, const std::string& rest_in);

// The same rows, and the warning of a bad fit, for a page with the colours of figure::embedded_style.
[[nodiscard]] std::string learned_table(const LearnedNet& learned);

}  // namespace springnet::tool
