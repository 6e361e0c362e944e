// What the rules conclude of one output, and the number that comes of it.
#pragma once

#include <optional>
#include <vector>

#include <springnet/fuzzy.hpp>

#include "fuzzy/conditions.hpp"
#include "fuzzy/functions.hpp"

namespace springnet::fuzzy {

// A conclusion of a rule that applies.
struct Drawn {
  std::size_t rule = 0;  // in Conditions::rules()
  std::size_t term = 0;
  TNorm activation = TNorm::minimum;
  OfOne strength;  // the rule's activation behind the hedges of the conclusion, and its derivative by the activation
};
[[nodiscard]] std::vector<Drawn> conclusions_of(const RuleBase& base, const Inputs& inputs,
                                                const Conditions& conditions, std::size_t output);

// The number for an output by its conclusions. DEFAULT, or nothing without one, if they conclude nothing.
[[nodiscard]] std::optional<Guess> guess_of(const Output& output, const std::vector<Drawn>& conclusions,
                                            const Conditions& conditions, const Inputs& inputs);
// Of a rule base that is checked.
[[nodiscard]] std::optional<Guess> guess_of_term(const Output& output, std::size_t term);

// Value and width of a guess, with their derivatives by numbers of which it is made.
struct Weights {
  double value = 0.0, width = 0.0;
  std::vector<double> value_by, width_by;
};

// An output's fuzzy set at the midpoints of its cells.
class FuzzySet {
 public:
  FuzzySet(const Output& output, const std::vector<Drawn>& conclusions);

  [[nodiscard]] bool is_empty() const noexcept { return area_ == 0.0; }
  [[nodiscard]] const std::vector<double>& memberships() const noexcept { return memberships_; }
  // By the memberships of the cells. Derivatives of LM, RM and MM are left 0.
  [[nodiscard]] Weights defuzzify() const;
  // Adds what derivatives by the memberships make of those by the conclusions' strengths, and by the numbers of the
  // output's terms.
  void add_backwards(const std::vector<double>& by_cell, std::vector<double>& by_strength,
                     std::vector<std::vector<double>>& by_numbers) const;

 private:
  [[nodiscard]] double midpoint(std::size_t cell) const;
  [[nodiscard]] double halving(std::vector<double>& by_cell) const;
  [[nodiscard]] double maximum() const;

  const Output& output_;
  const std::vector<Drawn>& conclusions_;
  std::vector<std::vector<double>> of_terms_;  // memberships of the terms that are concluded, at the cells
  std::vector<double> memberships_;
  double area_ = 0.0;  // the sum of memberships
};

// Throws Error(input) if the output's method looks for a maximum, which jumps.
void require_derivatives(const Output& output);

// Takagi-Sugeno: of numbers z with weights w. Derivatives are by the weights, then by the numbers.
[[nodiscard]] Weights weighted(Method method, const std::vector<double>& weights, const std::vector<double>& numbers);

// The number of a singleton or a linear term.
[[nodiscard]] double number_of(const Term& term, const Inputs& inputs);

}  // namespace springnet::fuzzy
