// Derivatives by all numbers of membership functions, and by the inputs, against central differences.
#include <algorithm>
#include <cmath>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include <springnet/fuzzy.hpp>

#include "random_base.hpp"

using namespace springnet;
using namespace springnet::fuzzy;

namespace {

struct Numbers {
  double value = 0.0, width = 0.0;
};

// (f(to) - f(from)) / (to - from)
template <class Function>
Numbers difference(const Function& at, double from, double to) {
  const Numbers above = at(to), below = at(from);
  return {(above.value - below.value) / (to - from), (above.width - below.width) / (to - from)};
}
double distance(const Numbers& a, const Numbers& b) {
  return std::max(std::abs(a.value - b.value), std::abs(a.width - b.width));
}

struct Compared {
  std::size_t compared = 0, left_out = 0, not_zero = 0;
  double largest = 0.0;
};

// At most this share may lie beside kinks, or the comparison means little: 4 % and 5 % are measured.
constexpr double most_left_out = 0.1;

// Differences of steps h have an error of h^2 and of rounding / h: 1e-7 with h = 1e-5, of derivatives of size 1. Left
// out is a kink at the place, where those to either side are not alike, and one nearby, where those of h and h / 2 are
// not.
template <class Function>
void compare(const Function& at, double by_value, double by_width, Compared& counts) {
  constexpr double h = 1e-5;
  const Numbers wide = difference(at, -h, h), narrow = difference(at, -0.5 * h, 0.5 * h);
  const double scale = 1.0 + std::abs(by_value) + std::abs(by_width);
  if (distance(difference(at, -h, 0.0), difference(at, 0.0, h)) > 1e-3 * scale ||
      distance(wide, narrow) > 2e-8 * scale) {
    ++counts.left_out;
    return;
  }
  ++counts.compared;
  if (by_value != 0.0) ++counts.not_zero;
  const double error = distance(narrow, {by_value, by_width}) / scale;
  counts.largest = std::max(counts.largest, error);
  CHECK(error < 1e-7);
}

}  // namespace

TEST_CASE("derivatives of value and width are those of differences") {
  Compared counts;
  for (unsigned seed = 0; seed < 100; ++seed) {
    testing::RandomBase random(seed);
    const RuleBase base = random.make(true);
    Inputs inputs = random.inputs(base);
    if (seed % 2 == 1) inputs[random.below(inputs.size())].reset();  // nothing is known of one
    CAPTURE(seed);
    const Evaluation evaluation = evaluate(base, inputs);
    for (std::size_t output = 0; output < base.outputs.size(); ++output) {
      const std::optional<Guess>& guess = evaluation.outputs[output];
      if (!guess || guess->is_otherwise) continue;
      const Gradient gradient = gradient_of(base, inputs, output);
      const std::vector<Parameter> parameters = parameters_of(base);
      REQUIRE(gradient.value.size() == parameters.size());
      REQUIRE(gradient.width.size() == parameters.size());
      const auto numbers = [&](const RuleBase& changed, const Inputs& at) {
        const std::optional<Guess> own = evaluate(changed, at).outputs[output];
        return own ? Numbers{own->value, own->width} : Numbers{std::nan(""), std::nan("")};
      };
      for (std::size_t i = 0; i < parameters.size(); ++i) {
        CAPTURE(i);
        const auto at = [&](double change) {
          RuleBase changed = base;
          number_of(changed, parameters[i]) += change;
          try {
            check(changed);
          } catch (const std::exception&) {
            return Numbers{change, change};  // two corners at the same place: left out
          }
          return numbers(changed, inputs);
        };
        const Parameter& own = parameters[i];
        const std::vector<double>& all =
            (own.is_output ? base.outputs[own.variable].terms : base.inputs[own.variable].terms)[own.term].numbers;
        // Beside a jump, of a corner on another, there is no derivative.
        const bool is_jump = std::count(all.begin(), all.end(), all[own.number]) > 1;
        if (!is_jump) compare(at, gradient.value[i], gradient.width[i], counts);
      }
      for (std::size_t i = 0; i < inputs.size(); ++i) {
        if (!inputs[i]) {
          CHECK(gradient.value_by_input[i] == 0.0);
          CHECK(gradient.width_by_input[i] == 0.0);
          continue;
        }
        const auto at = [&](double change) {
          Inputs changed = inputs;
          *changed[i] += change;
          return numbers(base, changed);
        };
        compare(at, gradient.value_by_input[i], gradient.width_by_input[i], counts);
      }
    }
  }
  MESSAGE(fmt::format("{} derivatives, {} of them not 0, {} left out beside kinks, largest error {:.1e}",
                      counts.compared, counts.not_zero, counts.left_out, counts.largest));
  CHECK(counts.not_zero > 500);
  CHECK(static_cast<double>(counts.left_out) < most_left_out * static_cast<double>(counts.compared));
}

TEST_CASE("derivatives where no rule applies are 0") {
  const RuleBase base = parse_rules(
      "FUNCTION_BLOCK VAR_INPUT x : REAL; END_VAR VAR_OUTPUT y : REAL; END_VAR FUZZIFY x TERM low := Triangle 0 1 2; "
      "END_FUZZIFY DEFUZZIFY y RANGE := (0 .. 4); TERM a := Triangle 0 1 2; DEFAULT := 3; END_DEFUZZIFY RULEBLOCK RULE "
      "1 : "
      "IF x IS low THEN y IS a; END_RULEBLOCK END_FUNCTION_BLOCK",
      "a.fcl");
  CHECK(gradient_of(base, {5.0}, 0).value == std::vector<double>(6, 0.0));
  // A single rule that multiplies: the numbers of its term alone count.
  const Gradient gradient = gradient_of(base, {{}}, 0);
  CHECK(gradient.value_by_input == std::vector<double>{0.0});
}

TEST_CASE("derivatives of a term of an output alone") {
  Compared counts;
  for (unsigned seed = 0; seed < 30; ++seed) {
    testing::RandomBase random(seed);
    const RuleBase base = random.make(true);
    for (std::size_t output = 0; output < base.outputs.size(); ++output)
      for (std::size_t term = 0; term < base.outputs[output].terms.size(); ++term) {
        CAPTURE(seed);
        CAPTURE(term);
        if (!guess_of_term(base, output, term)) continue;
        const Gradient gradient = gradient_of_term(base, output, term);
        const std::vector<Parameter> parameters = parameters_of(base);
        for (std::size_t i = 0; i < parameters.size(); ++i) {
          const Parameter& own = parameters[i];
          if (!own.is_output || own.variable != output || own.term != term) {
            CHECK(gradient.value[i] == 0.0);
            continue;
          }
          const std::vector<double>& all = base.outputs[output].terms[term].numbers;
          if (std::count(all.begin(), all.end(), all[own.number]) > 1) continue;  // beside a jump
          const auto at = [&](double change) {
            RuleBase changed = base;
            number_of(changed, own) += change;
            try {
              const std::optional<Guess> guess = guess_of_term(changed, output, term);
              return guess ? Numbers{guess->value, guess->width} : Numbers{std::nan(""), std::nan("")};
            } catch (const std::exception&) {
              return Numbers{change, change};  // two corners at the same place: left out
            }
          };
          compare(at, gradient.value[i], gradient.width[i], counts);
        }
      }
  }
  MESSAGE(fmt::format("{} derivatives, {} of them not 0, {} left out beside kinks, largest error {:.1e}",
                      counts.compared, counts.not_zero, counts.left_out, counts.largest));
  CHECK(counts.not_zero > 200);
  CHECK(static_cast<double>(counts.left_out) < most_left_out * static_cast<double>(counts.compared));
}
