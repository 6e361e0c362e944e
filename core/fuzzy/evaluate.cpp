#include <algorithm>

#include <fmt/format.h>

#include <springnet/error.hpp>

#include "fuzzy/conclusions.hpp"
#include "fuzzy/names.hpp"

namespace springnet::fuzzy {
namespace {

std::vector<double> strengths_of(const std::vector<Drawn>& conclusions) {
  std::vector<double> strengths;
  for (const Drawn& each : conclusions) strengths.push_back(each.strength.value);
  return strengths;
}

std::vector<double> numbers_of(const Output& output, const std::vector<Drawn>& conclusions, const Inputs& inputs) {
  std::vector<double> numbers;
  for (const Drawn& each : conclusions) numbers.push_back(number_of(output.terms[each.term], inputs));
  return numbers;
}

// Derivatives of one number, by strengths of conclusions, degrees of inputs' terms, and numbers of the output's terms.
struct Backwards {
  std::vector<double> by_strength;
  std::vector<std::vector<double>> by_degree, by_output_numbers;
  std::vector<double> by_input;

  Backwards(const RuleBase& base, const Output& output, std::size_t conclusions)
      : by_strength(conclusions), by_input(base.inputs.size()) {
    for (const Variable& input : base.inputs) by_degree.emplace_back(input.terms.size());
    for (const Term& term : output.terms) by_output_numbers.emplace_back(term.numbers.size());
  }
};

void add_weighted(const Output& output, const std::vector<Drawn>& conclusions, const Inputs& inputs,
                  const std::vector<double>& by, Backwards& back) {
  const std::size_t count = conclusions.size();
  for (std::size_t i = 0; i < count; ++i) {
    back.by_strength[i] += by[i];
    const Term& term = output.terms[conclusions[i].term];
    std::vector<double>& numbers = back.by_output_numbers[conclusions[i].term];
    numbers.back() += by[count + i];
    if (term.shape != Shape::linear) continue;
    for (std::size_t input = 0; input < inputs.size(); ++input) {
      if (!inputs[input]) continue;
      numbers[input] += by[count + i] * *inputs[input];
      back.by_input[input] += by[count + i] * term.numbers[input];
    }
  }
}

// Through the rules to the inputs, and all numbers in the order of parameters_of().
std::vector<double> finish(const RuleBase& base, const Inputs& inputs, const Conditions& conditions, std::size_t output,
                           const std::vector<Drawn>& conclusions, Backwards& back) {
  for (std::size_t i = 0; i < conclusions.size(); ++i)
    conditions.add_backwards(conclusions[i].rule, back.by_strength[i] * conclusions[i].strength.derivative,
                             back.by_degree);
  std::vector<double> all;
  for (std::size_t input = 0; input < base.inputs.size(); ++input) {
    const std::vector<Term>& terms = base.inputs[input].terms;
    for (std::size_t term = 0; term < terms.size(); ++term) {
      std::vector<double> by_numbers(terms[term].numbers.size());
      const double by_degree = back.by_degree[input][term];
      if (inputs[input] && by_degree != 0.0) {
        back.by_input[input] += by_degree * membership(terms[term], *inputs[input], by_numbers).derivative;
        for (double& each : by_numbers) each *= by_degree;
      }
      all.insert(all.end(), by_numbers.begin(), by_numbers.end());
    }
  }
  for (std::size_t each = 0; each < base.outputs.size(); ++each)
    for (std::size_t term = 0; term < base.outputs[each].terms.size(); ++term) {
      if (each == output)
        all.insert(all.end(), back.by_output_numbers[term].begin(), back.by_output_numbers[term].end());
      else
        all.insert(all.end(), base.outputs[each].terms[term].numbers.size(), 0.0);
    }
  return all;
}

}  // namespace

std::optional<Guess> guess_of(const Output& output, const std::vector<Drawn>& conclusions, const Conditions& conditions,
                              const Inputs& inputs) {
  Guess result;
  result.activations.resize(output.terms.size());
  for (const Drawn& each : conclusions)
    result.activations[each.term] = std::max(result.activations[each.term], each.strength.value);
  std::optional<Weights> weights;
  if (!is_mamdani(output.method)) {
    const std::vector<double> strengths = strengths_of(conclusions);
    if (std::any_of(strengths.begin(), strengths.end(), [](double w) { return w > 0.0; }))
      weights = weighted(output.method, strengths, numbers_of(output, conclusions, inputs));
  } else if (!conclusions.empty()) {
    const FuzzySet set(output, conclusions);
    if (!set.is_empty()) weights = set.defuzzify();
  }
  if (weights) {
    result.value = weights->value;
    result.width = weights->width;
    for (std::size_t i = 0; i < conclusions.size(); ++i)
      if (i == 0 || conclusions[i].rule != conclusions[i - 1].rule)
        result.rules.push_back(conditions.rules()[conclusions[i].rule]);
    return result;
  }
  if (!output.otherwise) return std::nullopt;
  result.value = *output.otherwise;
  result.is_otherwise = true;
  return result;
}

Evaluation evaluate(const RuleBase& base, const Inputs& inputs) {
  check(base);
  const Conditions conditions(base, inputs);
  Evaluation result{conditions.degrees(), conditions.rules(), {}};
  for (std::size_t output = 0; output < base.outputs.size(); ++output)
    result.outputs.push_back(
        guess_of(base.outputs[output], conclusions_of(base, inputs, conditions, output), conditions, inputs));
  return result;
}

std::vector<Parameter> parameters_of(const RuleBase& base) {
  std::vector<Parameter> all;
  const auto add = [&](bool is_output, std::size_t variable, const Variable& own) {
    for (std::size_t term = 0; term < own.terms.size(); ++term)
      for (std::size_t number = 0; number < own.terms[term].numbers.size(); ++number)
        all.push_back({is_output, variable, term, number});
  };
  for (std::size_t i = 0; i < base.inputs.size(); ++i) add(false, i, base.inputs[i]);
  for (std::size_t i = 0; i < base.outputs.size(); ++i) add(true, i, base.outputs[i]);
  return all;
}

double& number_of(RuleBase& base, const Parameter& parameter) {
  Variable& variable = parameter.is_output ? base.outputs.at(parameter.variable) : base.inputs.at(parameter.variable);
  return variable.terms.at(parameter.term).numbers.at(parameter.number);
}

void require_derivatives(const Output& output) {
  if (output.method != Method::leftmost_maximum && output.method != Method::rightmost_maximum &&
      output.method != Method::mean_of_maximum)
    return;
  throw Error(ErrorKind::input,
              fmt::format("rule base: output '{}': METHOD {} has no derivatives, because maxima jump; "
                          "write METHOD : COG",
                          output.name, word_of(methods, output.method)));
}

Gradient gradient_of(const RuleBase& base, const Inputs& inputs, std::size_t output) {
  check(base);
  if (output >= base.outputs.size())
    throw Error(ErrorKind::input,
                fmt::format("rule base: there is no output {}; there are {}", output, base.outputs.size()));
  const Output& own = base.outputs[output];
  require_derivatives(own);
  const Conditions conditions(base, inputs);
  const std::vector<Drawn> conclusions = conclusions_of(base, inputs, conditions, output);
  Backwards of_value(base, own, conclusions.size()), of_width = of_value;
  if (!is_mamdani(own.method)) {
    const std::vector<double> strengths = strengths_of(conclusions);
    if (std::any_of(strengths.begin(), strengths.end(), [](double w) { return w > 0.0; })) {
      const Weights weights = weighted(own.method, strengths, numbers_of(own, conclusions, inputs));
      add_weighted(own, conclusions, inputs, weights.value_by, of_value);
      add_weighted(own, conclusions, inputs, weights.width_by, of_width);
    }
  } else if (!conclusions.empty()) {
    const FuzzySet set(own, conclusions);
    if (!set.is_empty()) {
      const Weights weights = set.defuzzify();
      set.add_backwards(weights.value_by, of_value.by_strength, of_value.by_output_numbers);
      set.add_backwards(weights.width_by, of_width.by_strength, of_width.by_output_numbers);
    }
  }
  Gradient result;
  result.value = finish(base, inputs, conditions, output, conclusions, of_value);
  result.width = finish(base, inputs, conditions, output, conclusions, of_width);
  result.value_by_input = std::move(of_value.by_input);
  result.width_by_input = std::move(of_width.by_input);
  return result;
}

}  // namespace springnet::fuzzy
