#include "scene/terms.hpp"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <springnet/suggestion.hpp>

namespace springnet::scene {
namespace {

constexpr std::string_view logarithm = "log10_";

std::string term_name(std::string_view words) {
  std::string name;
  for (const char c : words)
    name += c == ' ' || c == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

}  // namespace

bool is_logarithm(const fuzzy::Output& output) { return output.name.starts_with(logarithm); }

std::string_view key_of(const fuzzy::Output& output) {
  std::string_view name = output.name;
  if (is_logarithm(output)) name.remove_prefix(logarithm.size());
  return name;
}

std::optional<std::size_t> find_output(const fuzzy::RuleBase& base, std::string_view key) {
  for (std::size_t i = 0; i < base.outputs.size(); ++i)
    if (key_of(base.outputs[i]) == key) return i;
  return std::nullopt;
}

std::optional<std::size_t> find_term(const fuzzy::Variable& variable, std::string_view words) {
  const std::string name = term_name(words);
  for (std::size_t i = 0; i < variable.terms.size(); ++i)
    if (term_name(variable.terms[i].name) == name) return i;
  return std::nullopt;
}

std::vector<std::string> words_of(const fuzzy::Variable& variable) {
  std::vector<std::string> words;
  for (const fuzzy::Term& term : variable.terms) {
    std::string& name = words.emplace_back(term.name);
    std::replace(name.begin(), name.end(), '_', ' ');
  }
  return words;
}

bool gives(const fuzzy::RuleBase& base, std::size_t input, std::size_t output) {
  return std::any_of(base.blocks.begin(), base.blocks.end(), [&](const fuzzy::RuleBlock& block) {
    return std::any_of(block.rules.begin(), block.rules.end(),
                       [&](const fuzzy::Rule& rule) { return reads(rule, input) && concludes(rule, output); });
  });
}

std::vector<std::string> inputs_that_give(const fuzzy::RuleBase& base, std::size_t output) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < base.inputs.size(); ++i)
    if (gives(base, i, output)) names.push_back(base.inputs[i].name);
  return names;
}

std::vector<std::string> words_for(const fuzzy::RuleBase& base, std::size_t output) {
  std::vector<std::string> known = words_of(base.outputs[output]);
  for (std::size_t i = 0; i < base.inputs.size(); ++i) {
    if (!gives(base, i, output)) continue;
    const std::vector<std::string> own = words_of(base.inputs[i]);
    known.insert(known.end(), own.begin(), own.end());
  }
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  return known;
}

std::string nearest_or_all(std::string_view words, const std::vector<std::string>& known) {
  const std::string nearest = suggestion(words, known);
  return nearest.empty() ? fmt::format("known: {}", fmt::join(known, ", ")) : nearest;
}

}  // namespace springnet::scene
