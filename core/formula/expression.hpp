// Formulas as text: what is written, with its place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace springnet::formula {

// Bounds on what one text may ask for; far above what a law needs.
inline constexpr std::size_t max_length = 10'000;  // bytes
inline constexpr std::size_t max_depth = 100;      // of brackets and signs within each other
inline constexpr std::size_t max_terms = 2'000;

enum class Operation : std::uint8_t {
  number,
  name,
  negative,
  sum,
  difference,
  product,
  quotient,
  power,
  less,
  less_or_equal,
  both,
  either,
  negation,
  call
};

struct Term {
  Operation operation = Operation::number;
  std::size_t place = 0;  // byte in the text
  double number = 0.0;
  std::string name;                      // of a name or call
  std::vector<std::uint32_t> arguments;  // terms
};

// "name = value;" before the formula.
struct Definition {
  std::string name;
  std::size_t place = 0;
};

// What is written, with names that stand for a part of it replaced by that part. Terms come after their arguments.
struct Expression {
  std::string text;
  std::vector<Term> terms;
  std::uint32_t root = 0;
  std::vector<Definition> definitions;

  [[nodiscard]] const Term& operator[](std::uint32_t term) const { return terms[term]; }
};

// Throws Error(input): what is wrong, its column, the text and a caret below it.
[[nodiscard]] Expression parse(std::string_view text);

// One call whose arguments are numbers: "area(0, 1, 2)".
[[nodiscard]] Expression parse_scalar(std::string_view text);

// The Error(input) of a mistake at a place: "column 7: …", the line and a caret.
[[noreturn]] void fail_at(std::string_view text, std::size_t place, std::string_view what);

// Whether a text may name a parameter, a state or the like: a letter, then letters, digits and '_', no word of the
// language and no function.
[[nodiscard]] bool is_name(std::string_view text);
[[nodiscard]] bool is_function(std::string_view text);
// All functions, for messages.
[[nodiscard]] const std::vector<std::string>& function_names();

}  // namespace springnet::formula
