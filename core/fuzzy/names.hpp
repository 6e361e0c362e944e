// The words of FCL for what a rule base is made of, as IEC 61131-7 and fuzzylite have them.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/fuzzy.hpp>

namespace springnet::fuzzy {

template <class Kind>
struct Word {
  std::string_view text;
  Kind kind;
};
template <class Kind>
Word(const char*, Kind) -> Word<Kind>;  // Clang 14 deduces none of aggregates

inline constexpr std::array t_norms{Word{"MIN", TNorm::minimum},    Word{"PROD", TNorm::product},
                                    Word{"BDIF", TNorm::bounded},   Word{"DPROD", TNorm::drastic},
                                    Word{"EPROD", TNorm::einstein}, Word{"HPROD", TNorm::hamacher},
                                    Word{"NMIN", TNorm::nilpotent}};
inline constexpr std::array s_norms{Word{"MAX", SNorm::maximum},   Word{"ASUM", SNorm::sum},
                                    Word{"BSUM", SNorm::bounded},  Word{"NSUM", SNorm::normalised},
                                    Word{"DSUM", SNorm::drastic},  Word{"ESUM", SNorm::einstein},
                                    Word{"HSUM", SNorm::hamacher}, Word{"NMAX", SNorm::nilpotent}};
inline constexpr std::array hedges{
    Word{"any", Hedge::any},           Word{"not", Hedge::negation},        Word{"very", Hedge::very},
    Word{"somewhat", Hedge::somewhat}, Word{"extremely", Hedge::extremely}, Word{"seldom", Hedge::seldom}};
inline constexpr std::array methods{Word{"COG", Method::centre_of_gravity}, Word{"COA", Method::centre_of_area},
                                    Word{"LM", Method::leftmost_maximum},   Word{"RM", Method::rightmost_maximum},
                                    Word{"MM", Method::mean_of_maximum},    Word{"COGS", Method::centre_of_singletons},
                                    Word{"COGSS", Method::weighted_sum}};
inline constexpr std::array shapes{Word{"Triangle", Shape::triangle}, Word{"Trapezoid", Shape::trapezoid},
                                   Word{"Gaussian", Shape::gaussian}, Word{"Sigmoid", Shape::sigmoid},
                                   Word{"Linear", Shape::linear}};

// Letters of the alphabet of ASCII alone. A name may have '_' as a letter.
[[nodiscard]] bool is_letter(char c) noexcept;
[[nodiscard]] bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept;

template <class Kind, std::size_t count>
[[nodiscard]] const Kind* find_word(const std::array<Word<Kind>, count>& words, std::string_view text) {
  for (const Word<Kind>& each : words)
    if (equal_ignoring_case(each.text, text)) return &each.kind;
  return nullptr;
}
template <class Kind, std::size_t count>
[[nodiscard]] std::string_view word_of(const std::array<Word<Kind>, count>& words, Kind kind) {
  for (const Word<Kind>& each : words)
    if (each.kind == kind) return each.text;
  return {};
}
template <class Kind, std::size_t count>
[[nodiscard]] std::vector<std::string> texts_of(const std::array<Word<Kind>, count>& words) {
  std::vector<std::string> texts;
  for (const Word<Kind>& each : words) texts.emplace_back(each.text);
  return texts;
}
template <class Named>
[[nodiscard]] std::vector<std::string> names_of(const std::vector<Named>& all) {
  std::vector<std::string> names;
  for (const Named& each : all) names.push_back(each.name);
  return names;
}
template <class Named>
[[nodiscard]] const Named* find_name(const std::vector<Named>& all, std::string_view name) {
  for (const Named& each : all)
    if (each.name == name) return &each;
  return nullptr;
}

// Whether FCL can have it as the name of a variable, a term, a block: letters, digits and '_', no word of the language.
[[nodiscard]] bool is_name(std::string_view text);
[[nodiscard]] bool is_language_word(std::string_view text);

// "did you mean 'low'?", or the list of what there is: "there is low, high".
[[nodiscard]] std::string remedy(std::string_view name, const std::vector<std::string>& known);

// A file may have at most so many.
struct Limits {
  static constexpr std::size_t bytes = 1'000'000;
  static constexpr std::size_t variables = 200, terms = 200, points = 1000, blocks = 200, rules = 2000;
  static constexpr std::size_t nodes = 1000, depth = 50, hedges = 20, name = 200;
};

}  // namespace springnet::fuzzy
