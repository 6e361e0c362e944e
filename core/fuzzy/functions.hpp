// Norms, hedges and membership functions with their derivatives. At kinks the derivatives are those of one side.
#pragma once

#include <span>
#include <string_view>

#include <springnet/fuzzy.hpp>

namespace springnet::fuzzy {

struct OfOne {
  double value = 0.0, derivative = 0.0;
};
struct OfTwo {
  double value = 0.0, by_first = 0.0, by_second = 0.0;
};

[[nodiscard]] OfTwo combine(TNorm norm, double a, double b);
[[nodiscard]] OfTwo combine(SNorm norm, double a, double b);
[[nodiscard]] OfOne hedged(Hedge hedge, double membership);
// From the last to the first.
[[nodiscard]] OfOne hedged(std::span<const Hedge> hedges, double membership);

// Degree at x of a term that is neither a singleton nor linear, and its derivative by x. `by_numbers`: empty, or one
// for each number of the term.
[[nodiscard]] OfOne membership(const Term& term, double x, std::span<double> by_numbers = {});

[[nodiscard]] constexpr bool is_mamdani(Method method) {
  return method != Method::centre_of_singletons && method != Method::weighted_sum;
}
[[nodiscard]] constexpr bool is_consequent_only(Shape shape) {
  return shape == Shape::singleton || shape == Shape::linear;
}

}  // namespace springnet::fuzzy
