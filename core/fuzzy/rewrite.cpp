// A file with other numbers in its terms, and all else as it was: comments with sources outlive what is learned.
#include <algorithm>

#include <fmt/format.h>

#include <springnet/error.hpp>
#include <springnet/printable.hpp>

#include "fuzzy/names.hpp"
#include "fuzzy/scanner.hpp"

namespace springnet::fuzzy {
namespace {

bool is(const Token& token, std::string_view word_or_symbol) {
  return token.kind != Token::Kind::number && equal_ignoring_case(token.text, word_or_symbol);
}

bool have_same_names(const RuleBase& a, const RuleBase& b) {
  const auto same_terms = [](const auto& first, const auto& second) {
    return std::equal(first.begin(), first.end(), second.begin(), second.end(), [](const auto& x, const auto& y) {
      return x.name == y.name && std::equal(x.terms.begin(), x.terms.end(), y.terms.begin(), y.terms.end(),
                                            [](const Term& s, const Term& t) {
                                              return s.name == t.name && s.shape == t.shape &&
                                                     s.numbers.size() == t.numbers.size();
                                            });
    });
  };
  return same_terms(a.inputs, b.inputs) && same_terms(a.outputs, b.outputs);
}

const Term& find_term(const RuleBase& base, std::string_view variable, std::string_view term) {
  const Variable* owner = find_name(base.inputs, variable);
  if (owner == nullptr) owner = find_name(base.outputs, variable);
  return *find_name(owner->terms, term);
}

}  // namespace

std::string with_numbers_of(std::string_view fcl, const RuleBase& base) {
  check(base);
  if (!have_same_names(parse_rules(fcl, "rule base"), base))
    throw Error(ErrorKind::input,
                "rule base: the text has other variables or terms than the numbers are of; write it anew");
  // What was read is FCL, so that a term is TERM name := numbers and symbols ;
  Scanner scanner(fcl, "rule base");
  std::string result, variable;
  std::size_t copied = 0;
  const std::size_t skipped = fcl.starts_with("\xEF\xBB\xBF") ? 3 : 0;  // places count from behind this mark
  while (scanner.peek().kind != Token::Kind::end) {
    const Token token = scanner.take();
    if (is(token, "FUZZIFY") || is(token, "DEFUZZIFY")) {
      variable = scanner.take().text;
    } else if (is(token, "TERM")) {
      const Term& term = find_term(base, variable, scanner.take().text);
      for (std::size_t i = 0; !is(scanner.peek(), ";");) {
        const Token part = scanner.take();
        if (part.kind != Token::Kind::number) continue;
        const double number = term.numbers[i++];
        if (number == part.number) continue;
        result += fcl.substr(copied, skipped + part.place - copied);
        result += fmt::format("{}", number);
        copied = skipped + part.place + part.text.size();
      }
    }
  }
  return result += fcl.substr(copied);
}

}  // namespace springnet::fuzzy
