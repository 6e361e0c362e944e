// Rule bases that learn: from values that bodies turned out to have, to terms that would have guessed them.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <springnet/export.hpp>
#include <springnet/fuzzy.hpp>

namespace springnet::fuzzy {

// What an output should have been.
struct Example {
  std::size_t output = 0;
  Inputs inputs;
  std::optional<std::size_t> term;  // said of the output itself: the inputs do not count
  double value = 0.0;               // in the output's unit: of log10_X the logarithm
  double deviation = 0.0;           // standard deviation of `value` as it was measured, 0 or above
};

// Terms are shifted and stretched, so that a membership function keeps its form: its numbers become
// centre + shift + (number - centre) exp(stretch), with the centre of the term as it was.
struct TermChange {
  std::size_t output = 0, term = 0;
  double shift = 0.0;    // in the output's unit
  double stretch = 0.0;  // of the logarithm of the width; 0 for a single number
};

struct CorrectionOptions {
  // How far bodies are from what is said of them, in widths of the guess before: standard deviation. An example counts
  // with the square sum of this and its own deviation, so that many that are wrong in the same way move a term, and one
  // alone hardly does.
  double spread = 1.0;
  // Standard deviations of what is not known beforehand: how far all terms of an output are off together, and each by
  // itself, in widths of the term; and of the logarithm of a width.
  double common_shift = 1.0, shift = 0.5, stretch = 0.2;
};

struct Correction {
  RuleBase base;
  std::vector<TermChange> changes;                  // of terms that an example depends on
  std::vector<double> common_shifts;                // [output] of all of its terms, part of their shifts
  std::vector<std::optional<Guess>> before, after;  // of the examples
  double start_cost = 0.0, cost = 0.0;  // 1/2 sum of the squares of differences in deviations, and of the changes
};

// The most likely terms of the outputs, by Levenberg's and Marquardt's method: derivatives of the defuzzified values
// pass through to the numbers of the membership functions. Terms of inputs, rules and their weights stay. Throws
// Error(input) if there are no examples, for one that no rule applies to, or whose numbers are not finite, for outputs
// whose method looks for a maximum, and for options that are not above 0 (spread: 0 or above, with deviations above 0).
[[nodiscard]] SPRINGNET_API Correction correct(const RuleBase& base, const std::vector<Example>& examples,
                                               const CorrectionOptions& options = {});

}  // namespace springnet::fuzzy
