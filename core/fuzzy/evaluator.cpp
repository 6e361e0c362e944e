#include "fuzzy/conclusions.hpp"

namespace springnet::fuzzy {

Evaluator::Evaluator(std::shared_ptr<const RuleBase> base) : base_(std::move(base)) { check(*base_); }

const std::optional<Guess>& Evaluator::guess(std::size_t output, const Inputs& inputs) {
  check_inputs(*base_, inputs);  // before a search by them, which NaN would mislead
  const Output& own = base_->outputs.at(output);
  const std::pair key(output, inputs);
  if (const auto known = guesses_.find(key); known != guesses_.end()) return known->second;
  const Conditions conditions(*base_, inputs);
  const std::vector<Drawn> conclusions = conclusions_of(*base_, inputs, conditions, output);
  return guesses_.emplace(key, guess_of(own, conclusions, conditions, inputs)).first->second;
}

const std::optional<Guess>& Evaluator::guess_of_term(std::size_t output, std::size_t term) {
  const Output& own = base_->outputs.at(output);
  const std::pair key(output, term);
  if (const auto known = of_terms_.find(key); known != of_terms_.end()) return known->second;
  return of_terms_.emplace(key, fuzzy::guess_of_term(own, term)).first->second;
}

}  // namespace springnet::fuzzy
