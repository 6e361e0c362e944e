// The formulas of a law as nodes of a graph, with their derivatives by the arguments of the law.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "formula/expression.hpp"
#include "formula/forward.hpp"
#include "formula/symbols.hpp"

namespace springnet::formula {

// Values of formulas in the numbers of an algebra (Plain, or Forward of one). `argument(column)`: the law's arguments.
template <class Algebra, class Argument>
class Evaluation {
 public:
  using Number = typename Algebra::Number;

  Evaluation(const Algebra& algebra, Symbols& symbols, const Argument& argument)
      : algebra_(algebra), symbols_(symbols), argument_(argument) {}

  [[nodiscard]] Number value(const Expression& formula) {
    std::vector<Number> values;
    values.reserve(formula.terms.size());
    std::vector<bool> needed(formula.terms.size(), false);
    needed[formula.root] = true;
    for (std::size_t i = formula.terms.size(); i-- > 0;) {
      const Term& term = formula.terms[i];
      if (needed[i] && !is_part(term))
        for (const std::uint32_t a : term.arguments) needed[a] = true;
    }
    for (std::size_t i = 0; i < formula.terms.size(); ++i)
      values.push_back(needed[i] ? of(formula, formula.terms[i], values) : algebra_.constant(0.0));
    return values[formula.root];
  }

 private:
  static bool is_part(const Term& term) {
    return term.operation == Operation::call && (term.name == "rest" || term.name == "rate");
  }
  [[nodiscard]] Number condition(Code code, Node a, Node b) {
    Number result = algebra_.constant(0.0);
    return with_value(result, algebra_.graph().apply(code, a, b));
  }
  // Conditions are kept as numbers without derivatives.
  static Node with_value(const Node&, Node value) { return value; }
  template <class Other>
  static Other with_value(Other number, Node value) {
    number.value = with_value(number.value, value);
    return number;
  }

  [[nodiscard]] Number meaning(const Meaning& meaning, const sdk::JacobianLayout& layout) {
    const auto q = [&] { return argument_(layout.value()); };
    const auto reference = [&] { return argument_(layout.reference()); };
    switch (meaning.made) {
      case Made::elongation:
        return algebra_.difference(q(), reference());
      case Made::strain:
        return algebra_.quotient(algebra_.difference(q(), reference()), reference());
      case Made::stretch:
        return algebra_.quotient(q(), reference());
      case Made::strain_rate:
        return algebra_.quotient(argument_(layout.rate()), reference());
      default:
        return argument_(meaning.column);
    }
  }

  [[nodiscard]] Number of(const Expression& formula, const Term& term, const std::vector<Number>& values) {
    const auto arg = [&](std::size_t k) -> const Number& { return values[term.arguments[k]]; };
    const auto node = [&](std::size_t k) { return algebra_.value(arg(k)); };
    switch (term.operation) {
      case Operation::number:
        return algebra_.constant(term.number);
      case Operation::name:
        if (term.name == "nan") return algebra_.constant(std::numeric_limits<double>::quiet_NaN());
        if (term.name == "pi") return algebra_.constant(3.14159265358979323846);
        return meaning(symbols_.meaning_of(formula, term), symbols_.layout());
      case Operation::negative:
        return algebra_.negative(arg(0));
      case Operation::sum:
        return algebra_.sum(arg(0), arg(1));
      case Operation::difference:
        return algebra_.difference(arg(0), arg(1));
      case Operation::product:
        return algebra_.product(arg(0), arg(1));
      case Operation::quotient:
        return algebra_.quotient(arg(0), arg(1));
      case Operation::power:
        return power(formula, term, arg(0), arg(1));
      case Operation::less:
        return condition(Code::less, node(0), node(1));
      case Operation::less_or_equal:
        return condition(Code::less_or_equal, node(0), node(1));
      case Operation::both:
        return condition(Code::both, node(0), node(1));
      case Operation::either:
        return condition(Code::either, node(0), node(1));
      case Operation::negation:
        return with_value(algebra_.constant(0.0), algebra_.graph().apply(Code::negation, node(0)));
      case Operation::call:
        return call(formula, term, values);
    }
    return algebra_.constant(0.0);
  }

  // Whole exponents up to 16 are products, x^4 = (x x) (x x), x^5 = x^4 x; others are pow.
  [[nodiscard]] Number power(const Expression& formula, const Term& term, const Number& base, const Number& exponent) {
    const Term& written = formula[term.arguments[1]];
    constexpr double most = 16.0;
    if (written.operation == Operation::number && written.number >= 1.0 && written.number <= most &&
        written.number == static_cast<double>(static_cast<int>(written.number)))
      return product(base, static_cast<int>(written.number));
    return algebra_.apply(Code::power, base, exponent);
  }
  [[nodiscard]] Number product(const Number& base, int exponent) {
    if (exponent == 1) return base;
    const Number half = product(base, exponent / 2), square = algebra_.product(half, half);
    return exponent % 2 == 0 ? square : algebra_.product(square, base);
  }

  [[nodiscard]] Number call(const Expression& formula, const Term& term, const std::vector<Number>& values) {
    const auto arg = [&](std::size_t k) -> const Number& { return values[term.arguments[k]]; };
    if (const std::ptrdiff_t curve = symbols_.curve_of(term.name); curve >= 0)
      return algebra_.curve(Code::curve, static_cast<std::uint32_t>(curve), arg(0));
    if (is_part(term)) return argument_(symbols_.meaning_of_part(formula, term).column);
    const auto smaller = [&](const Number& a, const Number& b) {  // b where it is smaller, as std::min
      return algebra_.choose(algebra_.graph().apply(Code::less, algebra_.value(b), algebra_.value(a)), b, a);
    };
    const auto greater = [&](const Number& a, const Number& b) {
      return algebra_.choose(algebra_.graph().apply(Code::less, algebra_.value(a), algebra_.value(b)), b, a);
    };
    if (term.name == "if") return algebra_.choose(algebra_.value(arg(0)), arg(1), arg(2));
    if (term.name == "min") return smaller(arg(0), arg(1));
    if (term.name == "max") return greater(arg(0), arg(1));
    if (term.name == "clamp") {  // x < low ? low : high < x ? high : x
      const Node x = algebra_.value(arg(0));
      const auto is_less = [&](Node a, Node b) { return algebra_.graph().apply(Code::less, a, b); };
      return algebra_.choose(is_less(x, algebra_.value(arg(1))), arg(1),
                             algebra_.choose(is_less(algebra_.value(arg(2)), x), arg(2), arg(0)));
    }
    for (const auto& [name, code] :
         {std::pair("pow", Code::power), std::pair("hypot", Code::hypot), std::pair("atan2", Code::atan2)})
      if (term.name == name) return algebra_.apply(code, arg(0), arg(1));
    for (const auto& [name, code] :
         {std::pair("abs", Code::absolute), std::pair("floor", Code::floor), std::pair("ceil", Code::ceil),
          std::pair("sqrt", Code::sqrt),    std::pair("cbrt", Code::cbrt),   std::pair("exp", Code::exp),
          std::pair("expm1", Code::expm1),  std::pair("log", Code::log),     std::pair("log1p", Code::log1p),
          std::pair("log10", Code::log10),  std::pair("sin", Code::sin),     std::pair("cos", Code::cos),
          std::pair("tan", Code::tan),      std::pair("asin", Code::asin),   std::pair("acos", Code::acos),
          std::pair("atan", Code::atan),    std::pair("sinh", Code::sinh),   std::pair("cosh", Code::cosh),
          std::pair("tanh", Code::tanh),    std::pair("erf", Code::erf)})
      if (term.name == name) return algebra_.apply(code, arg(0));
    fail_unknown_function(formula, term);
  }
  [[noreturn]] void fail_unknown_function(const Expression& formula, const Term& term) const;

  const Algebra& algebra_;
  Symbols& symbols_;
  const Argument& argument_;
};

[[noreturn]] void fail_unknown_function(const Expression& formula, const Term& term);
template <class Algebra, class Argument>
void Evaluation<Algebra, Argument>::fail_unknown_function(const Expression& formula, const Term& term) const {
  formula::fail_unknown_function(formula, term);
}

}  // namespace springnet::formula
