// Degrees of the inputs' terms, and what each rule's condition makes of them.
#pragma once

#include <vector>

#include <springnet/fuzzy.hpp>

#include "fuzzy/functions.hpp"

namespace springnet::fuzzy {

class Conditions {
 public:
  // Throws Error(input) if there are not as many inputs as the rule base has, or one is not finite.
  Conditions(const RuleBase& base, const Inputs& inputs);

  [[nodiscard]] const std::vector<std::vector<double>>& degrees() const noexcept { return degrees_; }
  // All rules in the order of the file: of the condition, times the rule's weight.
  [[nodiscard]] const std::vector<RuleActivation>& rules() const noexcept { return rules_; }
  // Adds to by_degree[input][term] what the derivative by rule `rule`'s activation makes there.
  void add_backwards(std::size_t rule, double by_activation, std::vector<std::vector<double>>& by_degree) const;

 private:
  const RuleBase& base_;
  const Inputs& inputs_;
  std::vector<std::vector<double>> degrees_;
  std::vector<RuleActivation> rules_;
  // Of each rule: nodes of its condition with their derivatives by what they combine; of a proposition, by its degree.
  std::vector<std::vector<OfTwo>> nodes_;
};

}  // namespace springnet::fuzzy
