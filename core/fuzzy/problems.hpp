// What a rule base must not have, as one clause without its place; empty where all is well.
#pragma once

#include <string>

#include <springnet/fuzzy.hpp>

namespace springnet::fuzzy {

[[nodiscard]] std::string problem_of(double number);
[[nodiscard]] std::string problem_of_range(double smallest, double largest);
[[nodiscard]] std::string problem_of_weight(double weight);
// Numbers of a term: how many there are, and their order. A linear one has `inputs` + 1.
[[nodiscard]] std::string problem_of(const Term& term, std::size_t inputs);
// Whether the term fits where it stands.
[[nodiscard]] std::string problem_of_input_term(const Term& term);
[[nodiscard]] std::string problem_of_output_term(const Term& term, Method method);

}  // namespace springnet::fuzzy
