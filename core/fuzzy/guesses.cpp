// Words alone, without rules: where a term of an input lies, and what a term of an output stands for.
#include <algorithm>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "fuzzy/conclusions.hpp"
#include "fuzzy/functions.hpp"

namespace springnet::fuzzy {
namespace {

// The first range of points that have the largest membership, of which the outer ones hold beyond their ends.
double middle_of_top(const Variable& variable, const std::vector<double>& at) {
  std::size_t first = 0, last = 0;
  for (std::size_t i = 2; i < at.size(); i += 2) {
    if (at[i + 1] > at[first + 1])
      first = last = i;
    else if (at[i + 1] == at[first + 1] && last + 2 == i)
      last = i;
  }
  const double begin = first == 0 ? variable.smallest : at[first];
  const double end = last + 2 == at.size() ? variable.largest : at[last];
  return 0.5 * (std::max(begin, variable.smallest) + std::min(end, variable.largest));
}

}  // namespace

double centre_of(const Variable& variable, const Term& term) {
  const std::vector<double>& at = term.numbers;
  const auto within = [&](double x) { return std::clamp(x, variable.smallest, variable.largest); };
  switch (term.shape) {
    case Shape::triangle:
      return within(at[1]);
    case Shape::trapezoid:
      return 0.5 * (within(at[1]) + within(at[2]));
    case Shape::sigmoid:
      return at[1] < 0.0 ? variable.smallest : variable.largest;
    case Shape::points:
      return middle_of_top(variable, at);
    default:
      return within(at[0]);
  }
}

std::optional<Guess> guess_of_term(const RuleBase& base, std::size_t output, std::size_t term) {
  check(base);
  return guess_of_term(base.outputs.at(output), term);
}

std::optional<Guess> guess_of_term(const Output& own, std::size_t term) {
  const Term& words = own.terms.at(term);
  Guess guess;
  guess.activations.resize(own.terms.size());
  guess.activations[term] = 1.0;
  if (words.shape == Shape::linear) return std::nullopt;
  if (words.shape == Shape::singleton) {
    guess.value = words.numbers[0];
    return guess;
  }
  const std::vector<Drawn> alone{{0, term, TNorm::minimum, {1.0, 0.0}}};
  const FuzzySet set(own, alone);
  if (set.is_empty()) return std::nullopt;
  const Weights weights = set.defuzzify();
  guess.value = weights.value;
  guess.width = weights.width;
  return guess;
}

Gradient gradient_of_term(const RuleBase& base, std::size_t output, std::size_t term) {
  check(base);
  const Output& own = base.outputs.at(output);
  const Term& words = own.terms.at(term);
  std::vector<double> value(words.numbers.size()), width(words.numbers.size());
  if (words.shape == Shape::singleton) {
    value[0] = 1.0;
  } else if (words.shape != Shape::linear) {
    require_derivatives(own);
    const std::vector<Drawn> alone{{0, term, TNorm::minimum, {1.0, 0.0}}};
    const FuzzySet set(own, alone);
    if (!set.is_empty()) {
      const Weights weights = set.defuzzify();
      const auto by_numbers = [&](const std::vector<double>& by_cell) {
        std::vector<double> by_strength(1);
        std::vector<std::vector<double>> all;
        for (const Term& each : own.terms) all.emplace_back(each.numbers.size());
        set.add_backwards(by_cell, by_strength, all);
        return all[term];
      };
      value = by_numbers(weights.value_by);
      width = by_numbers(weights.width_by);
    }
  }
  Gradient result;
  for (const Parameter& each : parameters_of(base)) {
    const bool is_own = each.is_output && each.variable == output && each.term == term;
    result.value.push_back(is_own ? value[each.number] : 0.0);
    result.width.push_back(is_own ? width[each.number] : 0.0);
  }
  result.value_by_input.resize(base.inputs.size());
  result.width_by_input.resize(base.inputs.size());
  return result;
}

double degree_of(const Term& term, double x) { return membership(term, x).value; }

std::vector<double> fuzzy_set_of(const RuleBase& base, const Inputs& inputs, std::size_t output) {
  check(base);
  const Output& own = base.outputs.at(output);
  const Conditions conditions(base, inputs);
  const std::vector<Drawn> conclusions = conclusions_of(base, inputs, conditions, output);
  if (!is_mamdani(own.method) || conclusions.empty()) return {};
  return FuzzySet(own, conclusions).memberships();
}

const RuleBase& soft_tissue() {
  static const RuleBase base = parse_rules(soft_tissue_fcl(), "soft_tissue.fcl");
  return base;
}

}  // namespace springnet::fuzzy
