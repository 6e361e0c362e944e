// Facts that a message has to have: numbers, names, options. How the sentence goes that has them is no test's business.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string>

namespace springnet::testing {

inline bool has_all(const std::string& text, std::initializer_list<const char*> facts) {
  return std::all_of(facts.begin(), facts.end(), [&](const char* f) { return text.find(f) != std::string::npos; });
}

}  // namespace springnet::testing
