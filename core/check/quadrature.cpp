#include "check/quadrature.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace springnet::check {
namespace {

struct Rule {
  std::vector<double> nodes, weights;  // on -1 to 1
};
// Gauss's rule: nodes are the roots of Legendre's polynomial, by Newton's method.
Rule gauss(int order) {
  Rule rule;
  for (int i = 0; i < order; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (order + 0.5)), slope = 1.0;
    for (int iteration = 0; iteration < 10; ++iteration) {
      double before = 1.0, p = x;
      for (int k = 2; k <= order; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p;
        p = next;
      }
      slope = order * (x * p - before) / (x * x - 1.0);
      x -= p / slope;
    }
    rule.nodes.push_back(x);
    rule.weights.push_back(2.0 / ((1.0 - x * x) * slope * slope));
  }
  return rule;
}
const std::array<Rule, 2>& rules() {
  static const std::array<Rule, 2> both{gauss(10), gauss(16)};
  return both;
}

struct Interval {
  double from, to;
};

// Of one pair over one interval.
struct Sum {
  double change = 0.0;
  std::array<double, 2> integrals{};  // by each rule
  double size = 0.0;                  // of the numbers that were added
};

// [interval][pair]; a pair that is not known or finite everywhere has a size of nan.
std::vector<std::vector<Sum>> sums_over(const Pairs& pairs, const std::vector<Interval>& intervals) {
  std::vector<double> xs;
  for (const Interval& each : intervals) {
    xs.insert(xs.end(), {each.from, each.to});
    const double middle = 0.5 * (each.from + each.to), half = 0.5 * (each.to - each.from);
    for (const Rule& rule : rules())
      for (const double node : rule.nodes) xs.push_back(middle + half * node);
  }
  const std::vector<Pair> answers = pairs(xs);
  std::vector<std::vector<Sum>> result(intervals.size(), std::vector<Sum>(answers.size()));
  std::size_t at = 0;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const double half = 0.5 * (intervals[i].to - intervals[i].from);
    for (std::size_t p = 0; p < answers.size(); ++p) {
      const Pair& pair = answers[p];
      Sum& sum = result[i][p];
      if (pair.values.size() != xs.size() || pair.derivatives.size() != xs.size()) {
        sum.size = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      sum.change = pair.values[at + 1] - pair.values[at];
      sum.size = std::abs(pair.values[at]) + std::abs(pair.values[at + 1]);
      std::size_t place = at + 2;
      for (std::size_t r = 0; r < rules().size(); ++r)
        for (const double weight : rules()[r].weights) {
          const double term = half * weight * pair.derivatives[place++];
          sum.integrals[r] += term;
          sum.size += std::abs(term);
        }
    }
    at += 2 + rules()[0].nodes.size() + rules()[1].nodes.size();
  }
  return result;
}

// Intervals that are the same but for a hundred-thousandth, so that all is rounded otherwise.
std::vector<Interval> varied(const Interval& interval) {
  const double step = 1e-5 * (interval.to - interval.from);
  std::vector<Interval> result{interval};
  for (const auto& [a, b] :
       std::array<std::array<double, 2>, 4>{{{0.31, 0.93}, {0.77, 0.17}, {0.53, 0.71}, {0.97, 0.41}}})
    result.push_back({interval.from + a * step, interval.to - b * step});
  return result;
}

// sums: [variation]
Comparison judge(const std::vector<Sum>& sums) {
  constexpr double safety = 30.0, rounding = 200.0 * std::numeric_limits<double>::epsilon(), least_accurate = 0.01;
  double low = std::numeric_limits<double>::infinity(), high = -low, uncertain = 0.0, size = 0.0;
  for (const Sum& sum : sums) {
    if (!std::isfinite(sum.size) || !std::isfinite(sum.change)) return {};
    const double defect = sum.change - sum.integrals[1];
    low = std::min(low, defect);
    high = std::max(high, defect);
    uncertain = std::max(uncertain, std::abs(sum.integrals[1] - sum.integrals[0]));
    size = std::max(size, sum.size);
  }
  const double error = safety * (high - low + uncertain) + rounding * size;
  const double defect = std::min(std::abs(low), std::abs(high));
  Comparison result{Verdict::agrees, sums[0].change, sums[0].integrals[1], error};
  if (low * high > 0.0 && defect > error) {
    result.verdict = Verdict::differs;
  } else if (error > least_accurate * std::max(std::abs(result.change), std::abs(result.integral)) &&
             error > 10.0 * rounding * size) {
    result.verdict = Verdict::undecided;
  }
  return result;
}

std::vector<Comparison> judge_over(const Pairs& pairs, const Interval& interval) {
  const std::vector<std::vector<Sum>> sums = sums_over(pairs, varied(interval));
  std::vector<Comparison> result;
  for (std::size_t p = 0; p < sums[0].size(); ++p) {
    std::vector<Sum> of_pair;
    for (const auto& each : sums) of_pair.push_back(each[p]);
    result.push_back(judge(of_pair));
  }
  return result;
}

}  // namespace

std::vector<Comparison> compare_over(const Pairs& pairs, double from, double to) {
  constexpr int parts = 7, needed = 5;
  std::vector<Comparison> result = judge_over(pairs, {from, to});
  if (std::none_of(result.begin(), result.end(), [](const Comparison& c) { return c.verdict == Verdict::differs; }))
    return result;
  std::vector<int> differing(result.size(), 0);
  for (int k = 0; k < parts; ++k) {
    const Interval part{from + (to - from) * k / parts, from + (to - from) * (k + 1) / parts};
    const std::vector<Comparison> of_part = judge_over(pairs, part);
    for (std::size_t p = 0; p < of_part.size(); ++p)
      if (of_part[p].verdict == Verdict::differs) ++differing[p];
  }
  for (std::size_t p = 0; p < result.size(); ++p)
    if (result[p].verdict == Verdict::differs && differing[p] < needed) result[p].verdict = Verdict::undecided;
  return result;
}

}  // namespace springnet::check
