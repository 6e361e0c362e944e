// Forward differentiation of formulas, as the SDK's dual numbers do it (sdk/dual.hpp), in steps of a graph. The order
// of operations is theirs, so that results have the same bits: values are computed as written, and derivatives that are
// 0 for certain take no arithmetic.
#pragma once

#include <cstddef>
#include <vector>

#include "formula/graph.hpp"

namespace springnet::formula {

// Plain numbers.
class Plain {
 public:
  using Number = Node;

  explicit Plain(Graph& graph) : graph_(graph) {}
  [[nodiscard]] Graph& graph() const { return graph_; }
  [[nodiscard]] Node constant(double value) const { return graph_.constant(value); }
  [[nodiscard]] Node value(Node x) const { return x; }
  [[nodiscard]] bool is_known_zero(Node x) const { return graph_.is_zero(x); }
  // Condition: x is 0.
  [[nodiscard]] Node is_nothing(Node x) const { return graph_.apply(Code::equal, x, constant(0.0)); }
  [[nodiscard]] Node negative(Node a) const { return graph_.negative(a); }
  [[nodiscard]] Node sum(Node a, Node b) const { return graph_.sum(a, b); }
  [[nodiscard]] Node difference(Node a, Node b) const { return graph_.difference(a, b); }
  [[nodiscard]] Node product(Node a, Node b) const { return graph_.product(a, b); }
  [[nodiscard]] Node quotient(Node a, Node b) const { return graph_.quotient(a, b); }
  [[nodiscard]] Node choose(Node condition, Node a, Node b) const { return graph_.choose(condition, a, b); }
  [[nodiscard]] Node apply(Code code, Node a) const { return graph_.apply(code, a); }
  [[nodiscard]] Node apply(Code code, Node a, Node b) const { return graph_.apply(code, a, b); }
  [[nodiscard]] Node curve(Code code, std::uint32_t table, Node a) const { return graph_.curve(code, table, a); }

 private:
  Graph& graph_;
};

// A value of Base's numbers, with derivatives by `count` variables.
template <class Base>
class Forward {
 public:
  using Inner = typename Base::Number;
  struct Number {
    Inner value;
    std::vector<Inner> derivatives;  // [count]
  };

  Forward(Base base, std::size_t count) : base_(base), count_(count) {}
  [[nodiscard]] Graph& graph() const { return base_.graph(); }
  [[nodiscard]] const Base& base() const { return base_; }
  [[nodiscard]] Number constant(double value) const { return lift(base_.constant(value)); }
  // A constant of Base's numbers.
  [[nodiscard]] Number lift(const Inner& value) const {
    return {value, std::vector<Inner>(count_, base_.constant(0.0))};
  }
  [[nodiscard]] Node value(const Number& x) const { return base_.value(x.value); }
  [[nodiscard]] bool is_known_zero(const Number& x) const {
    if (!base_.is_known_zero(x.value)) return false;
    for (const Inner& d : x.derivatives)
      if (!base_.is_known_zero(d)) return false;
    return true;
  }
  [[nodiscard]] Node is_nothing(const Number& x) const {
    Node all = base_.is_nothing(x.value);
    for (const Inner& d : x.derivatives)
      if (!base_.is_known_zero(d)) all = graph().apply(Code::both, all, base_.is_nothing(d));
    return all;
  }

  [[nodiscard]] Number negative(const Number& a) const {
    return each(base_.negative(a.value), [&](std::size_t i) { return base_.negative(a.derivatives[i]); });
  }
  [[nodiscard]] Number sum(const Number& a, const Number& b) const {
    return each(base_.sum(a.value, b.value),
                [&](std::size_t i) { return sum_of_derivatives(a.derivatives[i], b.derivatives[i]); });
  }
  [[nodiscard]] Number difference(const Number& a, const Number& b) const {
    return each(base_.difference(a.value, b.value),
                [&](std::size_t i) { return difference_of_derivatives(a.derivatives[i], b.derivatives[i]); });
  }
  [[nodiscard]] Number product(const Number& a, const Number& b) const {
    return each(base_.product(a.value, b.value), [&](std::size_t i) {
      return sum_of_derivatives(scaled(a.derivatives[i], b.value), scaled(b.derivatives[i], a.value));
    });
  }
  [[nodiscard]] Number quotient(const Number& a, const Number& b) const {
    const Inner ratio = base_.quotient(a.value, b.value);
    return each(ratio, [&](std::size_t i) {
      return divided(difference_of_derivatives(a.derivatives[i], scaled(b.derivatives[i], ratio)), b.value);
    });
  }
  [[nodiscard]] Number choose(Node condition, const Number& a, const Number& b) const {
    return each(base_.choose(condition, a.value, b.value),
                [&](std::size_t i) { return base_.choose(condition, a.derivatives[i], b.derivatives[i]); });
  }
  [[nodiscard]] Number curve(Code code, std::uint32_t table, const Number& a) const {
    const auto next = static_cast<Code>(static_cast<int>(code) + 1);
    const bool is_last = code == Code::curve_bend;  // third derivatives are not asked for
    return chain(a, base_.curve(code, table, a.value),
                 is_last ? base_.constant(0.0) : base_.curve(next, table, a.value));
  }
  [[nodiscard]] Number apply(Code code, const Number& x) const;
  [[nodiscard]] Number apply(Code code, const Number& x, const Number& y) const;

 private:
  template <class Derivative>
  [[nodiscard]] Number each(const Inner& value, const Derivative& derivative) const {
    Number result{value, {}};
    result.derivatives.reserve(count_);
    for (std::size_t i = 0; i < count_; ++i) result.derivatives.push_back(derivative(i));
    return result;
  }
  // As detail::sum(), difference(), scaled() and quotient() of sdk/dual.hpp.
  [[nodiscard]] Inner sum_of_derivatives(const Inner& a, const Inner& b) const {
    if (base_.is_known_zero(a)) return b;
    return base_.is_known_zero(b) ? a : base_.sum(a, b);
  }
  [[nodiscard]] Inner difference_of_derivatives(const Inner& a, const Inner& b) const {
    if (base_.is_known_zero(b)) return a;
    return base_.is_known_zero(a) ? base_.negative(b) : base_.difference(a, b);
  }
  [[nodiscard]] Inner divided(const Inner& derivative, const Inner& divisor) const {
    return base_.is_known_zero(derivative) ? derivative : base_.quotient(derivative, divisor);
  }
  [[nodiscard]] Inner scaled(const Inner& derivative, const Inner& factor) const {
    return base_.is_known_zero(derivative) ? derivative : base_.product(factor, derivative);
  }
  [[nodiscard]] Number chain(const Number& x, const Inner& value, const Inner& slope) const {
    return each(value, [&](std::size_t i) { return scaled(x.derivatives[i], slope); });
  }
  // Where the slope may be infinite, constants stay constants.
  [[nodiscard]] Number chain_steep(const Number& x, const Inner& value, const Inner& slope) const {
    return each(value, [&](std::size_t i) {
      const Inner& d = x.derivatives[i];
      if (base_.is_known_zero(d)) return d;
      return base_.choose(base_.is_nothing(d), base_.constant(0.0), base_.product(slope, d));
    });
  }
  [[nodiscard]] Inner one_over(const Inner& x) const { return base_.quotient(base_.constant(1.0), x); }
  [[nodiscard]] Inner number(double value) const { return base_.constant(value); }

  Base base_;
  std::size_t count_;
};

template <class Base>
typename Forward<Base>::Number Forward<Base>::apply(Code code, const Number& x) const {
  const Inner& v = x.value;
  const auto of = [&](Code other) { return base_.apply(other, v); };
  const Inner own = of(code);
  switch (code) {
    case Code::absolute: {
      const Node zero = graph().constant(0.0), at = base_.value(v);
      const Inner below = base_.choose(graph().apply(Code::less, at, zero), number(-1.0), number(0.0));
      return chain(x, own, base_.choose(graph().apply(Code::less, zero, at), number(1.0), below));
    }
    case Code::floor:
    case Code::ceil:
      return lift(own);
    case Code::sqrt:
      return chain_steep(x, own, base_.quotient(number(0.5), own));
    case Code::cbrt:
      return chain_steep(x, own, one_over(base_.product(base_.product(number(3.0), own), own)));
    case Code::exp:
      return chain(x, own, own);
    case Code::expm1:
      return chain(x, own, of(Code::expm1_slope));
    case Code::expm1_slope:
      return chain(x, own, own);
    case Code::log:
      return chain_steep(x, own, one_over(v));
    case Code::log1p:
      return chain_steep(x, own, one_over(base_.sum(number(1.0), v)));
    case Code::log10:
      return chain_steep(x, own, base_.quotient(number(0x1.bcb7b1526e50ep-2), v));  // log10 e
    case Code::sin:
      return chain(x, own, of(Code::cos));
    case Code::cos:
      return chain(x, own, base_.negative(of(Code::sin)));
    case Code::tan:
      return chain(x, own, base_.sum(number(1.0), base_.product(own, own)));
    case Code::asin:
    case Code::acos: {
      const Inner square = base_.product(base_.difference(number(1.0), v), base_.sum(number(1.0), v));
      return chain_steep(x, own,
                         base_.quotient(number(code == Code::asin ? 1.0 : -1.0), base_.apply(Code::sqrt, square)));
    }
    case Code::atan:
      return chain(x, own, one_over(base_.sum(number(1.0), base_.product(v, v))));
    case Code::sinh:
      return chain(x, own, of(Code::cosh));
    case Code::cosh:
      return chain(x, own, of(Code::sinh));
    case Code::tanh:
      return chain(x, own, base_.product(base_.difference(number(1.0), own), base_.sum(number(1.0), own)));
    default: {  // erf
      const Inner bell = base_.apply(Code::exp, base_.product(base_.negative(v), v));
      return chain(x, own, base_.product(number(0x1.20dd750429b6dp+0), bell));  // 2 / sqrt(pi)
    }
  }
}

template <class Base>
typename Forward<Base>::Number Forward<Base>::apply(Code code, const Number& x, const Number& y) const {
  const Inner own = base_.apply(code, x.value, y.value);
  const auto is_not_zero = [&](const Inner& a) {
    return graph().apply(Code::negation, graph().apply(Code::equal, base_.value(a), graph().constant(0.0)));
  };
  if (code == Code::power) {
    const Inner slope =
        base_.product(y.value, base_.apply(Code::power, x.value, base_.difference(y.value, number(1.0))));
    Number result = chain_steep(x, own, base_.choose(base_.is_nothing(y.value), number(0.0), slope));
    for (std::size_t i = 0; i < count_; ++i) {
      const Inner& d = y.derivatives[i];
      if (base_.is_known_zero(d)) continue;
      const Inner change = base_.product(base_.product(own, base_.apply(Code::log, x.value)), d);
      const Node counts =
          graph().apply(Code::both, graph().apply(Code::negation, base_.is_nothing(d)), is_not_zero(own));
      result.derivatives[i] =
          base_.choose(counts, sum_of_derivatives(result.derivatives[i], change), result.derivatives[i]);
    }
    return result;
  }
  if (code == Code::hypot) {
    return each(own, [&](std::size_t i) {
      const auto part = [&](const Number& of) { return scaled(of.derivatives[i], base_.quotient(of.value, own)); };
      return base_.choose(is_not_zero(own), sum_of_derivatives(part(x), part(y)), number(0.0));
    });
  }
  // atan2(x, y): the angle of (y, x).
  const Inner square = base_.sum(base_.product(y.value, y.value), base_.product(x.value, x.value));
  return each(own, [&](std::size_t i) {
    const Inner change =
        difference_of_derivatives(scaled(x.derivatives[i], y.value), scaled(y.derivatives[i], x.value));
    return base_.choose(is_not_zero(square), divided(change, square), number(0.0));
  });
}

}  // namespace springnet::formula
