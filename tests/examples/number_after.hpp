// Numbers in what an example prints.
#pragma once

#include <cstdlib>
#include <string>

#include <doctest/doctest.h>

namespace springnet::testing {

// The number behind the words.
inline double number_after(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  REQUIRE(at != std::string::npos);
  return std::strtod(text.c_str() + at + words.size(), nullptr);
}

}  // namespace springnet::testing
