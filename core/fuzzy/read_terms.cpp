// TERM name := Triangle a b c;   or Trapezoid, Gaussian, Sigmoid, Linear
// TERM name := (x, membership) (x, membership) ...;
// TERM name := number;
#include "fuzzy/problems.hpp"
#include "fuzzy/reader.hpp"

namespace springnet::fuzzy {

void Reader::read_term(Variable& variable) {
  const Token name = read_new_name("a term");
  if (find_name(variable.terms, name.text) != nullptr)
    scanner_.fail(name, fmt::format("'{}' has a term '{}' already; choose another name", variable.name, name.text));
  if (variable.terms.size() == Limits::terms)
    scanner_.fail(name, fmt::format("'{}' has more than {} terms", variable.name, Limits::terms));
  Term& term = variable.terms.emplace_back();
  term.name = name.text;
  expect(":=", "the name of a term");
  const Token begin = scanner_.peek();
  if (begin.kind == Token::Kind::word) {
    const Token word = scanner_.take();
    const Shape* const shape = find_word(shapes, word.text);
    if (shape == nullptr)
      scanner_.fail(word, fmt::format("{} is not a membership function; {}, or write points (x, membership)",
                                      shown(word), remedy(word.text, texts_of(shapes))));
    term.shape = *shape;
    while (scanner_.peek().kind == Token::Kind::number) {
      if (term.numbers.size() == Limits::variables)
        scanner_.fail(scanner_.peek(), fmt::format("term '{}' has more than {} numbers", term.name, Limits::variables));
      term.numbers.push_back(read_number("a number of a term"));
    }
  } else if (next_is("(")) {
    term.shape = Shape::points;
    read_points(term);
  } else if (begin.kind == Token::Kind::number) {
    term.shape = Shape::singleton;
    term.numbers = {read_number("a term")};
  } else {
    fail_unexpected("a membership function, points or a number");
  }
  expect(";", "a term");
  if (const std::string problem = problem_of(term, base_.inputs.size()); !problem.empty())
    scanner_.fail(begin, fmt::format("term '{}' {}", term.name, problem));
}

void Reader::read_points(Term& term) {
  while (take("(")) {
    if (term.numbers.size() == 2 * Limits::points)
      scanner_.fail(last_, fmt::format("term '{}' has more than {} points", term.name, Limits::points));
    term.numbers.push_back(read_number("a point's x"));
    expect(",", "a point's x");
    term.numbers.push_back(read_number("a point's membership"));
    expect(")", "a point");
  }
}

}  // namespace springnet::fuzzy
