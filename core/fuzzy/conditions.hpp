// Degrees of the inputs' terms, and what each rule's condition makes of them. Nothing is known of an input that is not
// given: each proposition about it may have any degree, so that conditions have a smallest and a largest degree, and a
// rule applies with the smallest. Norms rise with both of their arguments, negation swaps the two.
#pragma once

#include <vector>

#include <springnet/fuzzy.hpp>

#include "fuzzy/functions.hpp"

namespace springnet::fuzzy {

// The smallest and the largest degree of a part of a condition, each with its derivatives by the same one of the parts
// that it combines, by the other one for a negation; of a proposition, by its degree.
struct Bounds {
  OfTwo least, most;
};

// Throws Error(input) if there are not as many inputs as the rule base has, or one is not finite.
void check_inputs(const RuleBase& base, const Inputs& inputs);

class Conditions {
 public:
  // Throws as check_inputs().
  Conditions(const RuleBase& base, const Inputs& inputs);

  [[nodiscard]] const std::vector<std::vector<double>>& degrees() const noexcept { return degrees_; }
  // All rules in the order of the file: the smallest degree of the condition, times the rule's weight.
  [[nodiscard]] const std::vector<RuleActivation>& rules() const noexcept { return rules_; }
  // Adds to by_degree[input][term] what the derivative by rule `rule`'s activation makes there.
  void add_backwards(std::size_t rule, double by_activation, std::vector<std::vector<double>>& by_degree) const;

 private:
  const RuleBase& base_;
  const Inputs& inputs_;
  std::vector<std::vector<double>> degrees_;
  std::vector<RuleActivation> rules_;
  std::vector<std::vector<Bounds>> nodes_;  // [rule][node of its condition]
};

}  // namespace springnet::fuzzy
