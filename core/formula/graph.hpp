// Arithmetic on plain numbers: what formulas and their derivatives come down to. Equal steps are one node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

namespace springnet::formula {

using Node = std::uint32_t;
inline constexpr Node no_node = 0xffffffffu;

enum class Code : std::uint8_t {
  constant,
  input,
  negative,
  sum,
  difference,
  product,
  quotient,
  less,           // 1 or 0
  less_or_equal,  // likewise
  equal,
  both,
  either,
  negation,
  choose,  // a != 0 ? b : c
  absolute,
  floor,
  ceil,
  sqrt,
  cbrt,
  exp,
  expm1,
  expm1_slope,  // exp, with the bits that dual numbers have beside expm1
  log,
  log1p,
  log10,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  sinh,
  cosh,
  tanh,
  erf,
  power,
  hypot,
  atan2,
  curve,        // of a table, index: which
  curve_slope,  // its derivative
  curve_bend,   // its second derivative
  // Of programs alone: several steps in one loop, each rounded as by itself.
  product_sum,             // a b + c
  product_difference,      // a b - c
  difference_product,      // c - a b
  product_product,         // (a b) c
  product_product_sum,     // (a b) c + d
  product_sum_product,     // (a b + c) d
  sum_of_products,         // a b + c d
  sum_of_longer_products,  // (a b) c + d e
  products_difference,     // a b - c d
  expm1_and_slope          // two results
};

struct Step {
  Code code = Code::constant;
  Node a = no_node, b = no_node, c = no_node;
  std::uint32_t index = 0;  // of an input or a table
  double number = 0.0;
};

// Steps come after those whose results they take. Constants are computed, and a factor or divisor of 1 is left out,
// which changes no bits. A term or factor of 0 stays: 0 x has the sign of x, and is nan where x is infinite.
// Derivatives that are 0 for certain are left out by Forward.
class Graph {
 public:
  [[nodiscard]] Node constant(double value);
  [[nodiscard]] Node input(std::uint32_t index) { return add({Code::input, no_node, no_node, no_node, index, 0.0}); }
  [[nodiscard]] Node negative(Node a);
  [[nodiscard]] Node sum(Node a, Node b);
  [[nodiscard]] Node difference(Node a, Node b);
  [[nodiscard]] Node product(Node a, Node b);
  [[nodiscard]] Node quotient(Node a, Node b);
  [[nodiscard]] Node choose(Node condition, Node a, Node b);
  // Of one argument, two, or a table.
  [[nodiscard]] Node apply(Code code, Node a) { return add({code, a, no_node, no_node, 0, 0.0}); }
  [[nodiscard]] Node apply(Code code, Node a, Node b) { return add({code, a, b, no_node, 0, 0.0}); }
  [[nodiscard]] Node curve(Code code, std::uint32_t table, Node a) {
    return add({code, a, no_node, no_node, table, 0.0});
  }

  [[nodiscard]] bool is_constant(Node node) const { return steps_[node].code == Code::constant; }
  [[nodiscard]] bool is_zero(Node node) const { return is_constant(node) && steps_[node].number == 0.0; }
  [[nodiscard]] const Step& operator[](Node node) const { return steps_[node]; }
  [[nodiscard]] std::size_t size() const { return steps_.size(); }

 private:
  [[nodiscard]] bool is(Node node, double value) const { return is_constant(node) && steps_[node].number == value; }
  [[nodiscard]] Node add(const Step& step);

  std::vector<Step> steps_;
  std::map<std::tuple<Code, Node, Node, Node, std::uint32_t, std::uint64_t>, Node> known_;
};

}  // namespace springnet::formula
