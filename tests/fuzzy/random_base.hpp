// Rule bases made at random: all shapes, norms, hedges and methods.
#pragma once

#include <cstddef>
#include <random>

#include <springnet/fuzzy.hpp>

namespace springnet::testing {

class RandomBase {
 public:
  explicit RandomBase(unsigned seed) : random_(seed) {}

  // Outputs by Mamdani or Takagi-Sugeno rules. With derivatives: no norm and no method that jumps, and conditions with
  // negations of more than one proposition, which fuzzylite does not have.
  fuzzy::RuleBase make(bool with_derivatives = false);
  fuzzy::Inputs inputs(const fuzzy::RuleBase& base);
  double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
  std::size_t below(std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_); }
  bool one_in(std::size_t count) { return below(count) == 0; }

 private:
  fuzzy::Term term(const fuzzy::Variable& variable, std::size_t number);
  std::vector<fuzzy::Hedge> hedges(std::size_t most);
  std::size_t condition(fuzzy::Rule& rule, const fuzzy::RuleBase& base, std::size_t depth, bool with_negations);
  fuzzy::Rule rule(const fuzzy::RuleBase& base, std::size_t number, bool with_negations);
  template <class Norm>
  Norm norm(bool with_derivatives);

  std::mt19937 random_;
};

}  // namespace springnet::testing
