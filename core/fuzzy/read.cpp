// FUNCTION_BLOCK [name]
//   VAR_INPUT   name : REAL; ...  END_VAR
//   VAR_OUTPUT  name : REAL; ...  END_VAR
//   FUZZIFY input     RANGE := (a .. b);  TERM name := ...;  END_FUZZIFY
//   DEFUZZIFY output  the same, METHOD : COG;  ACCU : MAX;  DEFAULT := number or NC;  END_DEFUZZIFY
//   RULEBLOCK [name]  AND : MIN;  OR : MAX;  ACT : MIN;  ACCU : MAX;  RULE 1 : IF ... THEN ... WITH 0.5;  END_RULEBLOCK
// END_FUNCTION_BLOCK
#include <algorithm>
#include <limits>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "files/input_file.hpp"
#include "fuzzy/functions.hpp"
#include "fuzzy/problems.hpp"
#include "fuzzy/reader.hpp"

namespace springnet::fuzzy {
namespace {

// Without RANGE: what the terms' numbers span, of curves without an end as far as they are worth drawing.
void span_terms(Variable& variable) {
  double smallest = std::numeric_limits<double>::infinity(), largest = -smallest;
  const auto include = [&](double x) {
    smallest = std::min(smallest, x);
    largest = std::max(largest, x);
  };
  for (const Term& term : variable.terms) {
    const std::vector<double>& at = term.numbers;
    switch (term.shape) {
      case Shape::triangle:
      case Shape::trapezoid:
      case Shape::singleton:
        for (const double x : at) include(x);
        break;
      case Shape::points:
        for (std::size_t i = 0; i < at.size(); i += 2) include(at[i]);
        break;
      case Shape::gaussian:
        for (const double deviations : {-3.0, 3.0}) include(at[0] + deviations * at[1]);
        break;
      case Shape::sigmoid:  // 0.0025 and 0.9975 at the ends
        for (const double widths : {-6.0, 6.0}) include(at[1] == 0.0 ? at[0] : at[0] + widths / at[1]);
        break;
      case Shape::linear:
        break;
    }
  }
  if (!problem_of_range(smallest, largest).empty()) return;
  variable.smallest = smallest;
  variable.largest = largest;
}

}  // namespace

bool Reader::next_is(std::string_view word_or_symbol) const {
  const Token& next = scanner_.peek();
  return (next.kind == Token::Kind::word || next.kind == Token::Kind::symbol) &&
         equal_ignoring_case(next.text, word_or_symbol);
}

bool Reader::take(std::string_view word_or_symbol) {
  if (!next_is(word_or_symbol)) return false;
  last_ = scanner_.take();
  return true;
}

void Reader::expect(std::string_view word_or_symbol, std::string_view after) {
  if (take(word_or_symbol)) return;
  const Token& next = scanner_.peek();
  scanner_.fail(next, fmt::format("'{}' is missing after {}, before {}", word_or_symbol, after, shown(next)));
}

double Reader::read_number(std::string_view what) {
  const Token token = scanner_.take();
  if (token.kind != Token::Kind::number)
    scanner_.fail(token, fmt::format("{} must be a number, is {}", what, shown(token)));
  if (const std::string problem = problem_of(token.number); !problem.empty()) scanner_.fail(token, problem);
  return token.number;
}

void Reader::fail_unexpected(std::string_view wanted) {
  const Token& next = scanner_.peek();
  scanner_.fail(next, fmt::format("{} stands where {} is expected", shown(next), wanted));
}

RuleBase Reader::read() {
  if (!take("FUNCTION_BLOCK")) fail_unexpected("FUNCTION_BLOCK, with which FCL begins,");
  if (scanner_.peek().kind == Token::Kind::word && !is_language_word(scanner_.peek().text))
    base_.name = read_new_name("a rule base").text;
  for (;;) {
    if (take("VAR_INPUT"))
      read_variables(false);
    else if (take("VAR_OUTPUT"))
      read_variables(true);
    else if (take("FUZZIFY"))
      read_fuzzify();
    else if (take("DEFUZZIFY"))
      read_defuzzify();
    else if (take("RULEBLOCK"))
      read_rule_block();
    else if (take("END_FUNCTION_BLOCK"))
      break;
    else
      fail_unexpected("VAR_INPUT, VAR_OUTPUT, FUZZIFY, DEFUZZIFY, RULEBLOCK or END_FUNCTION_BLOCK");
  }
  check_outputs();
  if (scanner_.peek().kind != Token::Kind::end) fail_unexpected("the end of the file");
  return std::move(base_);
}

void Reader::check_outputs() const {
  if (base_.outputs.empty()) scanner_.fail(last_, "there is no output; declare one in VAR_OUTPUT");
  for (const Output& output : base_.outputs)
    if (output.terms.empty())
      scanner_.fail(last_, fmt::format("output '{0}' has no terms; write DEFUZZIFY {0} with them", output.name));
}

// A word that names something new.
Token Reader::read_new_name(std::string_view what) {
  const Token token = scanner_.take();
  if (token.kind != Token::Kind::word)
    scanner_.fail(token, fmt::format("the name of {} is missing before {}", what, shown(token)));
  if (token.text.size() > Limits::name)
    scanner_.fail(token, fmt::format("a name has at most {} letters, not {}", Limits::name, token.text.size()));
  if (is_language_word(token.text))
    scanner_.fail(token, fmt::format("{} is a word of FCL; choose another name for {}", shown(token), what));
  return token;
}

void Reader::read_variables(bool are_outputs) {
  while (!take("END_VAR")) {
    do {
      const Token name = read_new_name("a variable");
      const std::string text(name.text);
      if (find_name(base_.inputs, text) != nullptr || find_name(base_.outputs, text) != nullptr)
        scanner_.fail(name, fmt::format("a variable '{}' is already there; choose another name", text));
      if (base_.inputs.size() + base_.outputs.size() == Limits::variables)
        scanner_.fail(name, fmt::format("there are more than {} variables", Limits::variables));
      if (are_outputs) {
        base_.outputs.emplace_back().name = text;
        accumulation_.emplace_back();
      } else {
        base_.inputs.push_back({.name = text, .terms = {}, .has_range = false});
      }
    } while (take(","));
    expect(":", "the name of a variable");
    if (!take("REAL")) fail_unexpected("REAL, the type of variables here,");
    expect(";", "the type of a variable");
  }
}

void Reader::read_range(Variable& variable) {
  const std::size_t place = last_.place;
  expect(":=", "RANGE");
  expect("(", "RANGE :=");
  variable.smallest = read_number("a range's begin");
  expect("..", "a range's begin");
  variable.largest = read_number("a range's end");
  expect(")", "a range's end");
  expect(";", "a range");
  if (const std::string problem = problem_of_range(variable.smallest, variable.largest); !problem.empty())
    scanner_.fail(place, problem);
}

void Reader::read_fuzzify() {
  const Token name = scanner_.take();
  const auto found = std::find_if(base_.inputs.begin(), base_.inputs.end(),
                                  [&](const Variable& each) { return each.name == name.text; });
  if (found == base_.inputs.end())
    scanner_.fail(name, fmt::format("{} is not an input; {}", shown(name), remedy(name.text, names_of(base_.inputs))));
  if (!seen_.insert(name.text).second)
    scanner_.fail(name, fmt::format("input {} has a FUZZIFY block already; write all of its terms there", shown(name)));
  found->has_range = false;
  while (!take("END_FUZZIFY")) {
    if (take("RANGE")) {
      read_range(*found);
      found->has_range = true;
    } else if (take("TERM")) {
      const Token term = scanner_.peek();
      read_term(*found);
      if (const std::string problem = problem_of_input_term(found->terms.back()); !problem.empty())
        scanner_.fail(term, fmt::format("term {} {}", shown(term), problem));
    } else {
      fail_unexpected("TERM, RANGE or END_FUZZIFY");
    }
  }
  if (!found->has_range) span_terms(*found);
}

void Reader::read_defuzzify() {
  const Token name = scanner_.take();
  const auto found = std::find_if(base_.outputs.begin(), base_.outputs.end(),
                                  [&](const Output& each) { return each.name == name.text; });
  if (found == base_.outputs.end())
    scanner_.fail(name,
                  fmt::format("{} is not an output; {}", shown(name), remedy(name.text, names_of(base_.outputs))));
  if (!seen_.insert(name.text).second)
    scanner_.fail(name,
                  fmt::format("output {} has a DEFUZZIFY block already; write all of its terms there", shown(name)));
  found->has_range = false;
  std::vector<Token> terms;
  while (!take("END_DEFUZZIFY")) {
    if (take("RANGE")) {
      read_range(*found);
      found->has_range = true;
    } else if (take("TERM")) {
      terms.push_back(scanner_.peek());
      read_term(*found);
    } else if (take("METHOD")) {
      found->method = read_choice(methods, "METHOD");
    } else if (take("ACCU")) {
      found->accumulation = read_choice(s_norms, "ACCU");
      accumulation_[static_cast<std::size_t>(found - base_.outputs.begin())] = found->accumulation;
    } else if (take("DEFAULT")) {
      expect(":=", "DEFAULT");
      if (!take("NC")) found->otherwise = read_number("DEFAULT");  // NC, no change: there is nothing before
      expect(";", "DEFAULT");
    } else {
      fail_unexpected("TERM, RANGE, METHOD, ACCU, DEFAULT or END_DEFUZZIFY");
    }
  }
  for (std::size_t i = 0; i < terms.size(); ++i)
    if (const std::string problem = problem_of_output_term(found->terms[i], found->method); !problem.empty())
      scanner_.fail(terms[i], fmt::format("term {} {}", shown(terms[i]), problem));
  if (found->has_range) return;
  if (is_mamdani(found->method))
    scanner_.fail(name, fmt::format("output {} has no range to integrate over; write RANGE := (a .. b);", shown(name)));
  span_terms(*found);
}

RuleBase parse_rules(std::string_view text, std::string_view name) { return Reader(text, printable(name)).read(); }

RuleBase read_rules(const std::filesystem::path& file) {
  if (std::error_code unknown;
      std::filesystem::exists(file, unknown) && !std::filesystem::is_regular_file(file, unknown))
    throw Error(ErrorKind::input, fmt::format("{}: is not a file; give one with rules", printable(file.string())));
  InputFile in(file);
  std::string text;
  in.read(text, Limits::bytes + 1);
  const std::string name = file.string();
  if (text.size() > Limits::bytes)
    throw Error(ErrorKind::input,
                fmt::format("{}: has more than {} bytes; no rule base needs them", printable(name), Limits::bytes));
  return parse_rules(text, name);
}

}  // namespace springnet::fuzzy
