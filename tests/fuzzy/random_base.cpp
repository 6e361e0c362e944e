#include "random_base.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace springnet::testing {

using namespace fuzzy;

Term RandomBase::term(const Variable& variable, std::size_t number) {
  const double from = variable.smallest - 1.0, to = variable.largest + 1.0, extent = to - from;
  Term result{fmt::format("t{}", number), static_cast<Shape>(below(5)), {}};
  const auto rising = [&](std::size_t count) {
    std::vector<double> numbers(count);
    for (double& each : numbers) each = uniform(from, to);
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  };
  switch (result.shape) {
    case Shape::triangle:
      result.numbers = rising(3);
      if (one_in(5)) result.numbers[1] = result.numbers[one_in(2) ? 0 : 2];
      break;
    case Shape::trapezoid:
      result.numbers = rising(4);
      if (one_in(5)) result.numbers[1] = result.numbers[0];
      if (one_in(5)) result.numbers[2] = result.numbers[3];
      break;
    case Shape::gaussian:
      result.numbers = {uniform(from, to), extent * uniform(0.05, 0.5)};
      break;
    case Shape::sigmoid:
      result.numbers = {uniform(from, to), uniform(-30.0, 30.0) / extent};
      break;
    default: {
      const std::vector<double> at = rising(2 + below(4));
      for (const double x : at) {
        result.numbers.push_back(x);
        result.numbers.push_back(one_in(3) ? static_cast<double>(below(2)) : uniform(0.0, 1.0));
      }
    }
  }
  return result;
}

std::vector<Hedge> RandomBase::hedges(std::size_t most) {
  constexpr std::array all{Hedge::negation, Hedge::very, Hedge::somewhat, Hedge::extremely, Hedge::seldom};
  std::vector<Hedge> result(one_in(2) ? 0 : below(most + 1));
  for (Hedge& each : result) each = all[below(all.size())];
  return result;
}

std::size_t RandomBase::condition(Rule& rule, const RuleBase& base, std::size_t depth, bool with_negations) {
  ConditionNode node;
  if (depth == 0 || one_in(3)) {
    node.proposition.input = below(base.inputs.size());
    node.proposition.hedges = hedges(3);
    if (one_in(20)) node.proposition.hedges.push_back(Hedge::any);
    node.proposition.term = below(base.inputs[node.proposition.input].terms.size());
  } else {
    node.kind = one_in(2) ? ConditionNode::Kind::both : ConditionNode::Kind::either;
    node.left = condition(rule, base, depth - 1, with_negations);
    node.right = condition(rule, base, depth - 1, with_negations);
  }
  rule.condition.push_back(node);
  if (with_negations && node.kind != ConditionNode::Kind::proposition && one_in(3))
    rule.condition.push_back({ConditionNode::Kind::negation, {}, rule.condition.size() - 1, 0});
  return rule.condition.size() - 1;
}

Rule RandomBase::rule(const RuleBase& base, std::size_t number, bool with_negations) {
  Rule result;
  result.name = fmt::format("{}", number);
  condition(result, base, below(4), with_negations);
  for (std::size_t output = 0; output < base.outputs.size(); ++output)
    if (one_in(2) || (output + 1 == base.outputs.size() && result.conclusions.empty()))
      result.conclusions.push_back({output, {}, below(base.outputs[output].terms.size())});
  // Of the last conclusion alone: fuzzylite 6 applies the hedges of one to those behind it as well.
  result.conclusions.back().hedges = hedges(2);
  if (one_in(3)) result.weight = uniform(0.0, 1.0);
  return result;
}

template <class Norm>
Norm RandomBase::norm(bool with_derivatives) {
  for (;;) {
    const auto chosen = static_cast<Norm>(below(std::is_same_v<Norm, TNorm> ? 7 : 8));
    if (!with_derivatives) return chosen;
    if constexpr (std::is_same_v<Norm, TNorm>) {
      if (chosen != TNorm::drastic && chosen != TNorm::nilpotent) return chosen;
    } else {
      if (chosen != SNorm::drastic && chosen != SNorm::nilpotent) return chosen;
    }
  }
}

RuleBase RandomBase::make(bool with_derivatives) {
  RuleBase base;
  base.name = "random";
  const auto add_range = [&](Variable& variable, const std::string& name) {
    variable.name = name;
    variable.smallest = uniform(-10.0, 10.0);
    variable.largest = variable.smallest + uniform(0.5, 20.0);
  };
  base.inputs.resize(1 + below(3));
  for (std::size_t i = 0; i < base.inputs.size(); ++i) {
    add_range(base.inputs[i], fmt::format("x{}", i));
    const std::size_t terms = 1 + below(5);
    for (std::size_t t = 0; t < terms; ++t) base.inputs[i].terms.push_back(term(base.inputs[i], t));
  }
  base.outputs.resize(1 + below(3));
  for (std::size_t i = 0; i < base.outputs.size(); ++i) {
    Output& output = base.outputs[i];
    add_range(output, fmt::format("y{}", i));
    output.method = static_cast<Method>(below(7));
    if (with_derivatives) {
      constexpr std::array smooth{Method::centre_of_gravity, Method::centre_of_area, Method::centre_of_singletons,
                                  Method::weighted_sum};
      output.method = smooth[below(smooth.size())];
    }
    const std::size_t terms = 1 + below(5);
    const bool is_mamdani = output.method != Method::centre_of_singletons && output.method != Method::weighted_sum;
    if (is_mamdani) output.accumulation = norm<SNorm>(with_derivatives);
    for (std::size_t t = 0; t < terms; ++t) {
      if (is_mamdani) {
        output.terms.push_back(term(output, t));
        continue;
      }
      Term number{fmt::format("t{}", t), one_in(2) ? Shape::singleton : Shape::linear, {}};
      const std::size_t count = number.shape == Shape::singleton ? 1 : base.inputs.size() + 1;
      for (std::size_t n = 0; n < count; ++n) number.numbers.push_back(uniform(-5.0, 5.0));
      output.terms.push_back(number);
    }
    if (one_in(2)) output.otherwise = uniform(output.smallest, output.largest);
  }
  base.blocks.resize(1 + below(2));
  for (std::size_t b = 0; b < base.blocks.size(); ++b) {
    RuleBlock& block = base.blocks[b];
    block.name = fmt::format("block{}", b);
    block.conjunction = norm<TNorm>(with_derivatives);
    block.disjunction = norm<SNorm>(with_derivatives);
    block.activation = norm<TNorm>(with_derivatives);
    const std::size_t rules = 1 + below(6);
    for (std::size_t r = 0; r < rules; ++r) block.rules.push_back(rule(base, r + 1, with_derivatives));
  }
  return base;
}

Inputs RandomBase::inputs(const RuleBase& base) {
  Inputs result;
  for (const Variable& input : base.inputs) result.emplace_back(uniform(input.smallest, input.largest));
  return result;
}

}  // namespace springnet::testing
