// Numbers in a page: each block is base64 in an element of its own.
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "view/base64.hpp"
#include "view/rounding.hpp"

namespace springnet::view {

template <class Number>
void write_block(std::ostream& out, const std::string& name, const std::vector<Number>& numbers) {
  out << "<script type=\"application/octet-stream\" id=\"" << name << "\">" << base64_of(numbers) << "</script>\n";
}

// The range precedes the scaled numbers.
inline void write_rounded(std::ostream& out, const std::string& name, const std::vector<float>& numbers,
                          const Range& range) {
  write_block(out, name + "_range", std::vector<float>{range.low, range.high});
  write_block(out, name, shares_of(numbers, range));
}

}  // namespace springnet::view
