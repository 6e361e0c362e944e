// The terms and outputs of a rule base by the words and keys of a scene.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <springnet/fuzzy.hpp>

namespace springnet::scene {

// An output log10_NAME is the decimal logarithm of NAME.
[[nodiscard]] bool is_logarithm(const fuzzy::Output& output);
// The key that an output is for.
[[nodiscard]] std::string_view key_of(const fuzzy::Output& output);
[[nodiscard]] std::optional<std::size_t> find_output(const fuzzy::RuleBase& base, std::string_view key);

// "very soft" and "Very-Soft" are the term very_soft.
[[nodiscard]] std::optional<std::size_t> find_term(const fuzzy::Variable& variable, std::string_view words);
// Names of terms as a scene writes them: "very soft".
[[nodiscard]] std::vector<std::string> words_of(const fuzzy::Variable& variable);

// Whether a rule about the output reads the input.
[[nodiscard]] bool gives(const fuzzy::RuleBase& base, std::size_t input, std::size_t output);
// Names of the inputs that do.
[[nodiscard]] std::vector<std::string> inputs_that_give(const fuzzy::RuleBase& base, std::size_t output);
// Terms of the output itself, and of those inputs; sorted.
[[nodiscard]] std::vector<std::string> words_for(const fuzzy::RuleBase& base, std::size_t output);

// "did you mean 'liver'?", or all that there are.
[[nodiscard]] std::string nearest_or_all(std::string_view words, const std::vector<std::string>& known);

}  // namespace springnet::scene
