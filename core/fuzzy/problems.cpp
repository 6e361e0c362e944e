#include "fuzzy/problems.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "fuzzy/functions.hpp"
#include "fuzzy/names.hpp"

namespace springnet::fuzzy {
namespace {

std::string wrong_count(const Term& term, std::size_t inputs) {
  const auto wanted = [&](std::size_t count, std::string_view which) {
    return term.numbers.size() == count
               ? std::string()
               : fmt::format("has {} {}, must have {}", term.numbers.size(),
                             term.numbers.size() == 1 ? "number" : "numbers", fmt::format("{} ({})", count, which));
  };
  switch (term.shape) {
    case Shape::triangle:
      return wanted(3, "begin, top, end");
    case Shape::trapezoid:
      return wanted(4, "begin, begin and end of the top, end");
    case Shape::gaussian:
      return wanted(2, "mean, standard deviation");
    case Shape::sigmoid:
      return wanted(2, "inflection, slope");
    case Shape::singleton:
      return wanted(1, "the value");
    case Shape::linear:
      return wanted(inputs + 1, "one for each input, and the constant");
    case Shape::points:
      if (term.numbers.empty() || term.numbers.size() % 2 != 0) return "must have points, each (x, membership)";
      if (term.numbers.size() > 2 * Limits::points) return fmt::format("has more than {} points", Limits::points);
  }
  return {};
}

std::string wrong_order(const Term& term) {
  const std::vector<double>& at = term.numbers;
  switch (term.shape) {
    case Shape::triangle:
    case Shape::trapezoid:
      if (!std::is_sorted(at.begin(), at.end())) return "has numbers that fall; write them in rising order";
      if (at.front() == at.back()) return "has no extent; move its begin or its end";
      break;
    case Shape::gaussian:
      if (at[1] <= 0.0) return fmt::format("has a standard deviation of {}; it must be above 0", at[1]);
      break;
    case Shape::points:
      for (std::size_t i = 0; i < at.size(); i += 2) {
        if (i > 0 && at[i] < at[i - 2]) return "has points whose x falls; write them in rising order";
        if (at[i + 1] < 0.0 || at[i + 1] > 1.0)
          return fmt::format("has a point of membership {}; it must be from 0 to 1", at[i + 1]);
      }
      break;
    case Shape::sigmoid:
    case Shape::singleton:
    case Shape::linear:
      break;
  }
  return {};
}

}  // namespace

// Squares and quotients of such numbers are finite.
std::string problem_of(double number) {
  constexpr double smallest = 1e-100, largest = 1e100;
  const double size = std::abs(number);
  if (number == 0.0 || (size >= smallest && size <= largest)) return {};
  if (!std::isfinite(number)) return fmt::format("must be a finite number, is {}", number);
  return fmt::format("{} is too {} to compute with; a number must be 0, or from {} to {} without its sign", number,
                     size < smallest ? "small" : "large", smallest, largest);
}

std::string problem_of_range(double smallest, double largest) {
  for (const double end : {smallest, largest})
    if (std::string problem = problem_of(end); !problem.empty()) return problem;
  // Midpoints of cells have to differ.
  constexpr double narrowest = 1e-9;
  if (!(largest - smallest > narrowest * std::max(std::abs(smallest), std::abs(largest))))
    return fmt::format("the range must rise, from {} to {}", smallest, largest);
  return {};
}

std::string problem_of_weight(double weight) {
  if (weight >= 0.0 && weight <= 1.0) return {};
  return fmt::format("a weight must be from 0 to 1, is {}", weight);
}

std::string problem_of(const Term& term, std::size_t inputs) {
  if (std::string problem = wrong_count(term, inputs); !problem.empty()) return problem;
  for (const double number : term.numbers)
    if (const std::string problem = problem_of(number); !problem.empty())
      return "has a number out of bounds: " + problem;
  return wrong_order(term);
}

std::string problem_of_input_term(const Term& term) {
  if (!is_consequent_only(term.shape)) return {};
  return term.shape == Shape::linear
             ? "is linear, which has a meaning for outputs alone; write a membership function"
             : fmt::format(
                   "is a single number, which no measured value meets; write a narrow one, as Triangle {} {} {}",
                   term.numbers[0] - 1.0, term.numbers[0], term.numbers[0] + 1.0);
}

std::string problem_of_output_term(const Term& term, Method method) {
  const bool is_number = is_consequent_only(term.shape);
  if (is_number != is_mamdani(method)) return {};
  return is_number ? fmt::format("has no area, which METHOD {} needs; write a membership function, or METHOD : COGS",
                                 word_of(methods, method))
                   : fmt::format("is no number, which METHOD {} needs; write one number or Linear, or METHOD : COG",
                                 word_of(methods, method));
}

}  // namespace springnet::fuzzy
