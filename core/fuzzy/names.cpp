#include "fuzzy/names.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/suggestion.hpp>

namespace springnet::fuzzy {
namespace {

constexpr std::string_view language_words[] = {"FUNCTION_BLOCK",
                                               "END_FUNCTION_BLOCK",
                                               "VAR_INPUT",
                                               "VAR_OUTPUT",
                                               "END_VAR",
                                               "FUZZIFY",
                                               "END_FUZZIFY",
                                               "DEFUZZIFY",
                                               "END_DEFUZZIFY",
                                               "RULEBLOCK",
                                               "END_RULEBLOCK",
                                               "RANGE",
                                               "TERM",
                                               "METHOD",
                                               "ACCU",
                                               "DEFAULT",
                                               "RULE",
                                               "IF",
                                               "THEN",
                                               "IS",
                                               "AND",
                                               "OR",
                                               "NOT",
                                               "WITH",
                                               "ACT"};

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

}  // namespace

bool is_letter(char c) noexcept { return (lower(c) >= 'a' && lower(c) <= 'z') || c == '_'; }

bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

bool is_language_word(std::string_view text) {
  return std::any_of(std::begin(language_words), std::end(language_words),
                     [&](std::string_view word) { return equal_ignoring_case(word, text); }) ||
         find_word(hedges, text) != nullptr;
}

bool is_name(std::string_view text) {
  if (text.empty() || text.size() > Limits::name || !is_letter(text[0]) || is_language_word(text)) return false;
  return std::all_of(text.begin(), text.end(), [](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

std::string remedy(std::string_view name, const std::vector<std::string>& known) {
  if (known.empty()) return "there is none";
  const std::string nearest = suggestion(name, known);
  constexpr std::size_t most = 20;
  if (!nearest.empty()) return nearest;
  const std::vector<std::string> shown(known.begin(),
                                       known.begin() + static_cast<std::ptrdiff_t>(std::min(known.size(), most)));
  return fmt::format("there is {}{}", fmt::join(shown, ", "), known.size() > most ? ", …" : "");
}

}  // namespace springnet::fuzzy
