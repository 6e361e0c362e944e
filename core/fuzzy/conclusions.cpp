#include "fuzzy/conclusions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace springnet::fuzzy {
namespace {

// A standard deviation; 0 for one that rounding has made of equal numbers of this size.
double deviation(double variance, double size) {
  constexpr double rounding = 1e-14;
  const double root = std::sqrt(variance);
  return root > rounding * size ? root : 0.0;
}

// Whether a linear term reads an input that is not given.
bool is_undetermined(const Term& term, const Inputs& inputs) {
  if (term.shape != Shape::linear) return false;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (!inputs[i] && term.numbers[i] != 0.0) return true;
  return false;
}

}  // namespace

std::vector<Drawn> conclusions_of(const RuleBase& base, const Inputs& inputs, const Conditions& conditions,
                                  std::size_t output) {
  std::vector<Drawn> drawn;
  for (std::size_t i = 0; i < conditions.rules().size(); ++i) {
    const RuleActivation& rule = conditions.rules()[i];
    if (!(rule.activation > 0.0)) continue;
    const RuleBlock& block = base.blocks[rule.block];
    for (const Conclusion& conclusion : block.rules[rule.rule].conclusions) {
      if (conclusion.output != output) continue;
      if (is_undetermined(base.outputs[output].terms[conclusion.term], inputs)) continue;
      drawn.push_back({i, conclusion.term, block.activation, hedged(conclusion.hedges, rule.activation)});
    }
  }
  return drawn;
}

double number_of(const Term& term, const Inputs& inputs) {
  double number = term.numbers.back();
  if (term.shape == Shape::linear)
    for (std::size_t i = 0; i < inputs.size(); ++i)
      if (inputs[i]) number += term.numbers[i] * *inputs[i];
  return number;
}

FuzzySet::FuzzySet(const Output& output, const std::vector<Drawn>& conclusions)
    : output_(output), conclusions_(conclusions), of_terms_(output.terms.size()), memberships_(resolution) {
  for (const Drawn& each : conclusions) {
    std::vector<double>& own = of_terms_[each.term];
    if (!own.empty()) continue;
    own.resize(resolution);
    for (std::size_t cell = 0; cell < resolution; ++cell)
      own[cell] = membership(output.terms[each.term], midpoint(cell)).value;
  }
  for (std::size_t cell = 0; cell < resolution; ++cell) {
    double& sum = memberships_[cell];
    for (const Drawn& each : conclusions) {
      const double concluded = combine(each.activation, each.strength.value, of_terms_[each.term][cell]).value;
      sum = combine(output.accumulation, sum, concluded).value;
    }
    area_ += sum;
  }
}

double FuzzySet::midpoint(std::size_t cell) const {
  const double size = (output_.largest - output_.smallest) / static_cast<double>(resolution);
  return output_.smallest + (static_cast<double>(cell) + 0.5) * size;
}

Weights FuzzySet::defuzzify() const {
  double mean = 0.0, variance = 0.0;
  for (std::size_t cell = 0; cell < resolution; ++cell) mean += midpoint(cell) * memberships_[cell];
  mean /= area_;
  for (std::size_t cell = 0; cell < resolution; ++cell)
    variance += (midpoint(cell) - mean) * (midpoint(cell) - mean) * memberships_[cell];
  variance /= area_;
  const double width = deviation(variance, std::max(std::abs(output_.smallest), std::abs(output_.largest)));
  Weights result{mean, width, std::vector<double>(resolution), std::vector<double>(resolution)};
  for (std::size_t cell = 0; cell < resolution; ++cell) {
    const double from_mean = midpoint(cell) - mean;
    result.value_by[cell] = from_mean / area_;
    // The mean's own change does not count: sum (x - mean) mu = 0.
    if (width > 0.0) result.width_by[cell] = (from_mean * from_mean - variance) / (2.0 * width * area_);
  }
  if (output_.method == Method::centre_of_gravity) return result;
  std::fill(result.value_by.begin(), result.value_by.end(), 0.0);
  result.value = output_.method == Method::centre_of_area ? halving(result.value_by) : maximum();
  return result;
}

// Where half of the area lies on either side, memberships being constant within a cell.
double FuzzySet::halving(std::vector<double>& by_cell) const {
  const double size = (output_.largest - output_.smallest) / static_cast<double>(resolution);
  double before = 0.0;
  std::size_t cell = 0;
  while (cell + 1 < resolution && before + memberships_[cell] < 0.5 * area_) before += memberships_[cell++];
  const double own = memberships_[cell], share = (0.5 * area_ - before) / own;
  for (std::size_t i = 0; i < resolution; ++i)
    by_cell[i] = size * (0.5 - (i < cell ? 1.0 : 0.0) - (i == cell ? share : 0.0)) / own;
  return output_.smallest + (static_cast<double>(cell) + share) * size;
}

// Of the leftmost range of cells that have the largest membership, or the rightmost cell of all. A plateau is one
// although its memberships differ by rounding.
double FuzzySet::maximum() const {
  constexpr double rounding = 1e-12;
  const double least = *std::max_element(memberships_.begin(), memberships_.end()) - rounding;
  const auto is_maximum = [&](double membership) { return membership >= least; };
  const auto first = std::find_if(memberships_.begin(), memberships_.end(), is_maximum);
  const auto end = std::find_if_not(first, memberships_.end(), is_maximum);
  const auto cell = [&](auto at) { return static_cast<std::size_t>(at - memberships_.begin()); };
  switch (output_.method) {
    case Method::leftmost_maximum:
      return midpoint(cell(first));
    case Method::rightmost_maximum: {
      const auto last = std::find_if(memberships_.rbegin(), memberships_.rend(), is_maximum);
      return midpoint(cell(last.base() - 1));
    }
    default:
      return 0.5 * (midpoint(cell(first)) + midpoint(cell(end - 1)));
  }
}

void FuzzySet::add_backwards(const std::vector<double>& by_cell, std::vector<double>& by_strength,
                             std::vector<std::vector<double>>& by_numbers) const {
  const std::size_t count = conclusions_.size();
  std::vector<OfTwo> concluded(count), sums(count);
  std::vector<std::vector<double>> of_numbers(output_.terms.size());
  for (std::size_t cell = 0; cell < resolution; ++cell) {
    if (by_cell[cell] == 0.0) continue;
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const Drawn& each = conclusions_[i];
      concluded[i] = combine(each.activation, each.strength.value, of_terms_[each.term][cell]);
      sums[i] = combine(output_.accumulation, sum, concluded[i].value);
      sum = sums[i].value;
    }
    std::vector<double> by_term(output_.terms.size());
    double by_sum = by_cell[cell];
    for (std::size_t i = count; i-- > 0;) {
      const double by_concluded = by_sum * sums[i].by_second;
      by_strength[i] += by_concluded * concluded[i].by_first;
      by_term[conclusions_[i].term] += by_concluded * concluded[i].by_second;
      by_sum *= sums[i].by_first;
    }
    for (std::size_t term = 0; term < by_term.size(); ++term) {
      if (by_term[term] == 0.0) continue;
      std::vector<double>& own = of_numbers[term];
      own.resize(output_.terms[term].numbers.size());
      static_cast<void>(membership(output_.terms[term], midpoint(cell), own));
      for (std::size_t i = 0; i < own.size(); ++i) by_numbers[term][i] += by_term[term] * own[i];
    }
  }
}

Weights weighted(Method method, const std::vector<double>& weights, const std::vector<double>& numbers) {
  const std::size_t count = weights.size();
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  double sum = 0.0, variance = 0.0;
  for (std::size_t i = 0; i < count; ++i) sum += weights[i] * numbers[i];
  const double mean = sum / total;
  for (std::size_t i = 0; i < count; ++i) variance += weights[i] * (numbers[i] - mean) * (numbers[i] - mean);
  variance /= total;
  double size = 0.0;
  for (const double number : numbers) size = std::max(size, std::abs(number));
  const double width = deviation(variance, size);
  const bool is_sum = method == Method::weighted_sum;
  Weights result{is_sum ? sum : mean, is_sum ? total * width : width, std::vector<double>(2 * count),
                 std::vector<double>(2 * count)};
  for (std::size_t i = 0; i < count; ++i) {
    const double from_mean = numbers[i] - mean;
    result.value_by[i] = is_sum ? numbers[i] : from_mean / total;
    result.value_by[count + i] = is_sum ? weights[i] : weights[i] / total;
    if (width == 0.0) continue;
    const double by_weight = (from_mean * from_mean - variance) / (2.0 * width * total);
    const double by_number = weights[i] * from_mean / (width * total);
    result.width_by[i] = is_sum ? width + total * by_weight : by_weight;
    result.width_by[count + i] = is_sum ? total * by_number : by_number;
  }
  return result;
}

}  // namespace springnet::fuzzy
