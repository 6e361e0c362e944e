// Facts that a message must contain: places, keys, names, numbers, options. Tests do not assert its wording.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>

namespace springnet::testing {

inline bool has_all(const std::string& text, std::initializer_list<const char*> facts) {
  return std::all_of(facts.begin(), facts.end(), [&](const char* f) { return text.find(f) != std::string::npos; });
}

// The same with the facts in one text, separated by " | ".
inline bool has_facts(std::string_view text, std::string_view facts) {
  constexpr std::string_view separator = " | ";
  for (std::size_t end = 0; (end = facts.find(separator)) != std::string_view::npos;
       facts.remove_prefix(end + separator.size()))
    if (text.find(facts.substr(0, end)) == std::string_view::npos) return false;
  return text.find(facts) != std::string_view::npos;
}

}  // namespace springnet::testing
