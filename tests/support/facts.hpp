// Facts that a message must contain: places, keys, names, numbers, options. Tests do not assert its wording.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string>
#include <string_view>

namespace springnet::testing {

inline bool has(std::string_view text, std::string_view fact) { return text.find(fact) != std::string_view::npos; }

inline bool has_all(const std::string& text, std::initializer_list<const char*> facts) {
  return std::all_of(facts.begin(), facts.end(), [&](const char* f) { return has(text, f); });
}

// The same with the facts in one text, separated by " | ".
inline bool has_facts(std::string_view text, std::string_view facts) {
  constexpr std::string_view separator = " | ";
  for (std::size_t end = 0; (end = facts.find(separator)) != std::string_view::npos;
       facts.remove_prefix(end + separator.size()))
    if (!has(text, facts.substr(0, end))) return false;
  return has(text, facts);
}

}  // namespace springnet::testing
