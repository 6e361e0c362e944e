// What was learned, as a page: the course of the search, and the values with their intervals.
#pragma once

#include <string>

#include <springnet/learn.hpp>

namespace springnet::tool {

[[nodiscard]] std::string page_of(const std::string& title, const LearnedNet& learned);

}  // namespace springnet::tool
