// fuzzylite, the field's library, reads the same files and has to come to the same numbers.
#include <cmath>
#include <memory>
#include <string>

#include <doctest/doctest.h>
#include <fl/Headers.h>
#include <fmt/format.h>

#include <springnet/fuzzy.hpp>

#include "random_base.hpp"

using namespace springnet;
using namespace springnet::fuzzy;

namespace {

// With as many cells, and comparisons of numbers as they are: by default fuzzylite takes two that differ by 1e-6 for
// equal, so that its memberships are off by as much beside the corners.
struct Oracle {
  explicit Oracle(const std::string& fcl) {
    fl::fuzzylite::setMachEps(0.0);
    fl::IntegralDefuzzifier::setDefaultResolution(static_cast<int>(resolution));
    engine.reset(fl::FclImporter().fromString(fcl));
    std::string problems;
    REQUIRE_MESSAGE(engine->isReady(&problems), problems);
    for (const fl::RuleBlock* block : engine->ruleBlocks())
      for (const fl::Rule* rule : block->rules()) REQUIRE(rule->isLoaded());
  }
  void process(const Inputs& inputs) {
    for (std::size_t i = 0; i < inputs.size(); ++i) engine->getInputVariable(i)->setValue(inputs[i].value());
    engine->process();
  }
  std::unique_ptr<fl::Engine> engine;
};

// The same sums in the same order differ by the rounding of exp, some 1e-16 of the range, and by what cancels in the
// denominators of norms and the width of a set with a small area: 1e-9 leaves room for that and for no mistake.
constexpr double tolerance = 1e-9;

struct Counts {
  std::size_t values = 0, empty = 0, ties = 0, rounding = 0;
  double largest = 0.0;  // relative to the range
};

bool looks_for_maximum(Method method) {
  return method == Method::leftmost_maximum || method == Method::rightmost_maximum || method == Method::mean_of_maximum;
}

// Whether rounding may decide: of a norm that jumps, where a + b or the larger of them passes 1; and of fuzzylite's
// Hamacher sum, which loses all digits, and may be 2, where both are next to 1.
bool is_up_to_rounding(const RuleBase& base) {
  const auto jumps = [](auto norm) { return norm == decltype(norm)::drastic || norm == decltype(norm)::nilpotent; };
  const auto is_one = [&](SNorm norm) { return jumps(norm) || norm == SNorm::hamacher; };
  bool result = false;
  for (const RuleBlock& block : base.blocks)
    result = result || jumps(block.conjunction) || is_one(block.disjunction) || jumps(block.activation);
  for (const Output& output : base.outputs) result = result || is_one(output.accumulation);
  return result;
}

// Of fuzzylite's set, with plateaus to 1e-12.
double maximum(const Output& output, const fl::Aggregated& set) {
  const auto midpoint = [&](std::size_t cell) {
    return output.smallest +
           (static_cast<double>(cell) + 0.5) * (output.largest - output.smallest) / static_cast<double>(resolution);
  };
  double largest = 0.0;
  for (std::size_t i = 0; i < resolution; ++i) largest = std::max(largest, set.membership(midpoint(i)));
  const auto is_maximum = [&](std::size_t cell) { return set.membership(midpoint(cell)) >= largest - 1e-12; };
  std::size_t first = 0, last = resolution - 1;
  while (!is_maximum(first)) ++first;
  if (output.method == Method::leftmost_maximum) return midpoint(first);
  if (output.method == Method::rightmost_maximum) {
    while (!is_maximum(last)) --last;
    return midpoint(last);
  }
  for (last = first; last + 1 < resolution && is_maximum(last + 1);) ++last;
  return 0.5 * (midpoint(first) + midpoint(last));
}

void compare(const RuleBase& base, Oracle& oracle, const Inputs& inputs, Counts& counts) {
  const Evaluation evaluation = evaluate(base, inputs);
  oracle.process(inputs);
  for (std::size_t i = 0; i < base.inputs.size(); ++i)
    for (std::size_t t = 0; t < base.inputs[i].terms.size(); ++t)
      REQUIRE(std::abs(oracle.engine->getInputVariable(i)->getTerm(t)->membership(*inputs[i]) -
                       evaluation.degrees[i][t]) < 1e-14);
  for (const RuleActivation& rule : evaluation.rules) {
    const double theirs = oracle.engine->getRuleBlock(rule.block)->getRule(rule.rule)->getActivationDegree();
    if (std::abs(theirs - rule.activation) < tolerance) continue;
    REQUIRE(is_up_to_rounding(base));
    ++counts.rounding;
    return;
  }
  for (std::size_t i = 0; i < base.outputs.size(); ++i) {
    const Output& output = base.outputs[i];
    fl::OutputVariable* const variable = oracle.engine->getOutputVariable(i);
    const double theirs = variable->getValue(), range = output.largest - output.smallest;
    const std::optional<Guess>& ours = evaluation.outputs[i];
    CAPTURE(output.name);
    if (std::isnan(theirs) && ours && !ours->is_otherwise) {
      REQUIRE(is_up_to_rounding(base));  // the root of 1 - 1.0000000000000004
      ++counts.rounding;
      continue;
    }
    if (!ours || ours->is_otherwise) {
      // No rule applies, or the fuzzy set is empty: DEFAULT. Of an empty set fuzzylite has NaN, an end of the range as
      // its maximum, or the sum 0.
      ++counts.empty;
      const fl::Aggregated* const set = variable->fuzzyOutput();
      if (!set->isEmpty() && set->highestActivatedTerm()->getDegree() < 1e-12)
        ++counts.rounding;  // a bounded difference of 0, but for rounding
      else if (set->isEmpty())
        REQUIRE((ours ? ours->value == theirs : std::isnan(theirs)));
      else
        REQUIRE((std::isnan(theirs) || (looks_for_maximum(output.method) && set->membership(theirs) == 0.0) ||
                 (output.method == Method::weighted_sum && theirs == 0.0)));
      continue;
    }
    ++counts.values;
    const double difference = std::abs(theirs - ours->value) / std::max(range, std::abs(theirs));
    if (output.method == Method::centre_of_area) {
      // It weighs the two cells beside the middle, we divide a cell: they agree to a cell.
      if (difference <= 1.0 / static_cast<double>(resolution)) continue;
    }
    // Maxima that differ by rounding count as one plateau here.
    if (looks_for_maximum(output.method) && difference > tolerance &&
        std::abs(ours->value - maximum(output, *variable->fuzzyOutput())) < tolerance * range) {
      ++counts.ties;
      continue;
    }
    if (difference < tolerance) {
      counts.largest = std::max(counts.largest, difference);
      continue;
    }
    REQUIRE(is_up_to_rounding(base));
    ++counts.rounding;
  }
}

}  // namespace

TEST_CASE("a thousand random rule bases have fuzzylite's values") {
  Counts counts;
  for (unsigned seed = 0; seed < 1000; ++seed) {
    testing::RandomBase random(seed);
    const std::string fcl = to_fcl(random.make());
    CAPTURE(seed);
    CAPTURE(fcl);
    const RuleBase base = parse_rules(fcl, "random.fcl");
    Oracle oracle(fcl);
    for (int repetition = 0; repetition < 5; ++repetition) {
      const Inputs inputs = random.inputs(base);
      CAPTURE(*inputs[0]);
      compare(base, oracle, inputs, counts);
    }
  }
  MESSAGE(
      fmt::format("{} values, {} without rules, {} ties of maxima, {} that rounding decides, largest difference {:.1e} "
                  "of the range",
                  counts.values, counts.empty, counts.ties, counts.rounding, counts.largest));
  // The comparison means something: most outputs have a value, and few are ties.
  CHECK(counts.values > 8000);
  CHECK(counts.ties < counts.values / 100);
  CHECK(counts.rounding < counts.values / 100);
}

TEST_CASE("the shipped rule base has fuzzylite's values") {
  const std::string fcl(soft_tissue_fcl());  // as it is, with its comments
  const RuleBase& base = soft_tissue();
  Oracle oracle(fcl);
  Counts counts;
  testing::RandomBase random(1);
  for (int repetition = 0; repetition < 200; ++repetition) compare(base, oracle, random.inputs(base), counts);
  CHECK(counts.values > 900);
  CHECK(counts.rounding + counts.ties + counts.empty == 0);
  CHECK(counts.largest < tolerance);
}
